/// `vrda laxity`: laxity tests of a job.
#pragma once

#include <string>
#include <vector>

#include "core/console.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct LaxityOptions {
  std::string job_file, data_directory, folder;
  std::vector<std::string> overrides;
  std::string against;  ///< table of published values; empty: none
  bool may_replace = false;
  int n_threads = 0;  ///< 0: one per processor
  std::string progress = "auto";
  bool as_json = false;

  /// Declares the options of the command.
  void add_to(CLI::App& command);
};

/// Writes laxity.json, laxity.csv, share.csv and index.html into the folder and prints the laxities. Exit
/// code 3 if a load has no equilibrium. Throws InputError before solving if the job has no [laxity], or if
/// the folder has the result of another job.
core::ExitCode laxity_command(const LaxityOptions& options);

}  // namespace vrda::app
