/// `vrda run`: solves a job and writes its motion model.
#pragma once

#include <string>
#include <vector>

#include "app/talk.hpp"

namespace vrda {

struct RunOptions {
  std::string job_file;
  std::string output;  ///< empty: results/<job name>/<job name>.h5
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_threads = 0;          ///< 0: as many as there are processors
  bool is_fresh = false;      ///< drop a journal found
  bool writes_trace = false;  ///< every move of every search, beside the output
  std::string progress = "auto";
};

ExitCode run_command(const RunOptions& options);

}  // namespace vrda
