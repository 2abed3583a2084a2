/// `vrda shape`: writes a generated joint as STL files, and its ligaments as a table.
#pragma once

#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct ShapeOptions {
  std::string shape;
  std::string folder;
  std::vector<std::string> parameters;  ///< "name=value"
  bool has_ligaments = false;           ///< write ligaments.csv too
};

ExitCode shape_command(const ShapeOptions& options);

/// Every shape with its parameters, for `--help`.
std::string shape_help();

}  // namespace vrda
