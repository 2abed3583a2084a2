/// Starts tasks of a submission, the way that was asked for.
#pragma once

#include <string>

#include "cluster/jobs.hpp"
#include "cluster/submission.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct StartOptions {
  bool is_dry = false;
  bool is_local = false;
  int n_workers = 0;  ///< of a local run; 0: as many as there are processors
  bool as_json = false;
};

/// By local processes: returns when they have ended, with the worst of their exit codes. By Slurm: prints
/// what was submitted. Dry: prints what would be.
ExitCode start_tasks(const std::string& folder, const Submission& submission, const Work& work,
                     const StartOptions& options);

}  // namespace vrda
