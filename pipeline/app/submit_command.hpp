/// `vrda submit` and `vrda resume`: the cases of a job or campaign, by Slurm or by local processes.
#pragma once

#include <string>
#include <vector>

#include "cluster/submission.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct SubmitOptions {
  std::string job_file;  ///< a job or a campaign
  std::string folder;    ///< empty: results/<job name>
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_shards = 1;  ///< of each case
  SlurmOptions slurm;
  bool is_dry = false;    ///< print scripts and commands, write nothing
  bool is_local = false;  ///< run the tasks here, now
  int n_workers = 0;      ///< local processes at once; 0: as many as there are processors
  bool as_json = false;
};

/// Writes the submission's folder and starts all of its tasks. Throws InputError when the folder holds a
/// submission or a motion model that would be replaced; when Slurm refuses the first job, nothing of it is
/// left, when it refuses a later one, what it took goes on and vrda resume adds the rest.
ExitCode submit_command(const SubmitOptions& options);

struct ResumeOptions {
  std::string folder;
  SlurmOptions slurm;  ///< what is empty or 0 stays as it was
  bool is_dry = false;
  bool is_local = false;
  int n_workers = 0;
  bool as_json = false;
};

/// Starts the tasks that are missing and says why each is; never one that Slurm has queued or runs.
ExitCode resume_command(const ResumeOptions& options);

}  // namespace vrda
