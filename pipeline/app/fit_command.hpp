/// `vrda fit`: inputs of a job from measurements.
#pragma once

#include <string>
#include <vector>

#include "core/console.hpp"
#include "core/files.hpp"

namespace CLI {
class App;
}

namespace vrda::app {

struct FitCommandOptions {
  std::string job_file;
  std::vector<std::string> to_files;  ///< measured motions and laxities, for [[fit.parameter]]
  std::string motion;                 ///< poses in contact, table or motion model, for offset_mm = "fit"
  std::string rows;  ///< training frames of each motion: A:B, first-half or second-half; empty: all
  std::string translations = "rotation-centre";  ///< of `to_files`, or "mesh-origin"
  std::string angles;          ///< of the tables: deg or rad; empty: as they state, else degrees
  std::string output;          ///< resolved job with the number; empty: none
  bool may_replace = false;    ///< existing files at the output
  std::string data_directory;  ///< as of a run
  std::vector<std::string> overrides;
  bool is_fresh = false;
  int n_threads = 0;  ///< 0: one per processor
  std::string progress = "auto";
  bool as_json = false;

  /// Declares the options of the command.
  void add_to(CLI::App& command);
};

/// Throws InputError unless `may_replace` if one of the files of `result` exists: it could be an input.
void require_absent(const Publication& result, const FitCommandOptions& options,
                    const std::vector<std::string>& files);

/// With `to_files` identify(); else prints the offset with its standard error and the gaps of training and
/// other frames. Exit code 3 if it is not determined.
core::ExitCode fit_command(const FitCommandOptions& options);

/// Fits the unknowns of [fit] and prints them with what the measurements decide, and the misfits. Continues
/// from the journal next to `output`. Exit code 3 unless the fit converged.
core::ExitCode identify_command(const FitCommandOptions& options);

}  // namespace vrda::app
