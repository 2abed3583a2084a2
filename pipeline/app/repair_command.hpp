/// `vrda repair`: the nearest motion without overlap or lift-off.
#pragma once

#include <string>
#include <vector>

#include "core/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct RepairCommandOptions {
  std::string file, output;
  /// Standard deviations: one number, or three for the canonical axes X, Y and Z. Empty: not stated.
  std::vector<double> noise_mm, noise_deg;
  std::string smooth = "auto";  ///< "auto", "none" or a period in frames
  std::string gap_mm = "auto";  ///< "auto", "none" or a length
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  bool as_json = false;
};

/// Writes the repaired model, with the measured poses next to the repaired ones, and prints gap, overlap and
/// distance before and after. Exit code 3, with the model written, if a frame is not_converged.
core::ExitCode repair_command(const RepairCommandOptions& options);

/// Adds the options to a command.
void add_repair_options(CLI::App& command, RepairCommandOptions& options);

}  // namespace vrda::app
