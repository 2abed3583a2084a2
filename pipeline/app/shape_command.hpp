/// `vrda shape`: writes a generated joint as STL files.
#pragma once

#include <string>
#include <vector>

#include "app/talk.hpp"

namespace vrda {

struct ShapeOptions {
  std::string shape;
  std::string folder;
  std::vector<std::string> parameters;  ///< "name=value"
};

ExitCode shape_command(const ShapeOptions& options);

/// Every shape with its parameters, for `--help`.
std::string shape_help();

}  // namespace vrda
