/// `vrda import`: a measured motion as a motion model.
#pragma once

#include <string>
#include <vector>

#include "core/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct ImportOptions {
  std::string job_file;
  std::string data_directory;
  std::vector<std::string> overrides;
  std::string motion;            ///< file of the moving object's poses
  std::string reference_motion;  ///< file of the reference's poses in the same frame; may be empty
  /// Words of measured/motion_convention.hpp, "auto" (try all), or empty: as the file states, else try all.
  std::string unit, angles, order, direction, axes, side, lengths;
  std::string key;                   ///< column; empty: found
  std::vector<std::string> columns;  ///< COORDINATE=COLUMN
  std::string moving_prefix, reference_prefix;
  std::string output;  ///< may be empty: as of `vrda run`
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  bool as_json = false;
};

/// Prints the conventions tried with the gaps that they leave, and the path of the model. Throws InputError
/// with the options to add where conventions cannot be distinguished; nothing is then written.
core::ExitCode import_command(const ImportOptions& options);

/// Adds the options to a command.
void add_import_options(CLI::App& command, ImportOptions& options);

}  // namespace vrda::app
