/// `vrda fit`: the offset of components from a measured motion.
#pragma once

#include <string>
#include <vector>

#include "console/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct FitCommandOptions {
  std::string job_file;        ///< with offset_mm = "fit" at one component or more
  std::string motion;          ///< table of poses, or motion model
  std::string rows;            ///< training frames: A:B, first-half or second-half; empty: all
  std::string output;          ///< resolved job with the number; empty: none
  std::string data_directory;  ///< as of a run
  std::vector<std::string> overrides;
  bool as_json = false;

  /// Declares the options of the command.
  void add_to(CLI::App& command);
};

/// Prints the offset with its standard error and the gaps of training and other frames. Exit code 3 if it is
/// not determined.
console::ExitCode fit_command(const FitCommandOptions& options);

}  // namespace vrda::app
