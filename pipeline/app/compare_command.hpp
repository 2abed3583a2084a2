/// `vrda compare`: smoothing degrees side by side, and which to take.
#pragma once

#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct CompareCommandOptions {
  std::string file;
  std::string degrees = "1..12";  ///< ranges and numbers: "1..12", "2,4,6", "1..4,8"
  int refine = 2;                 ///< parts of a grid step that are audited; 1 the grid alone, 0 nothing
  int n_threads = 0;              ///< of the audit; 0: one a processor
  bool is_robust = false;
  bool is_recontacted = false;
  bool as_json = false;
};

/// The degrees that a text names, rising, each once. Throws InputError that names --degrees.
std::vector<int> degrees_of(const std::string& text);

/// Prints a row a degree and the recommendation. Changes nothing in the file.
ExitCode compare_command(const CompareCommandOptions& options);

}  // namespace vrda
