/// The commands that run many cases as many tasks.
#pragma once

#include <string>
#include <vector>

#include "core/console.hpp"
#include "job/case.hpp"
#include "run/campaign.hpp"
#include "run/submission.hpp"
#include "solve/sweep.hpp"

namespace vrda::app {

struct PlanOptions {
  std::string job_file;  ///< or a campaign
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_shards = 1;
  bool as_json = false;
};

/// Prints the cases and their estimated cost; solves nothing. Throws InputError for the first invalid case.
core::ExitCode plan_command(const PlanOptions& options);

/// A checked case of a campaign with its estimated cost.
struct PlannedCase {
  run::CampaignCase campaign_case;
  job::Case job_case;  ///< without bodies, survey and job text
  solve::SweepPlan plan;
  run::CaseSize size;
  run::CaseCost cost;
  std::string same_as;        ///< an earlier case with the same motion; empty: none
  std::string same_steps_as;  ///< an earlier case that differs only in scaling and can share its journal
};

/// Reads every job, and each set of meshes once. Throws InputError for the first invalid case; with several
/// cases the message names it. Cost: a few ms per case, plus loading each set of meshes.
std::vector<PlannedCase> planned_cases(const run::Campaign& campaign);

/// `vrda index`: writes one table of the results of a submission.
struct IndexOptions {
  std::string folder;  ///< of a submission
  bool as_json = false;
  int n_processes = 0;  ///< processes that read models; 0: one per processor
};

/// Writes index.csv, index.h5 and index.times.csv into the folder and prints their paths. Unfinished cases
/// get rows too. Throws InputError if the submission is missing or the files cannot be written.
core::ExitCode index_command(const IndexOptions& options);

/// As index_command, for a submission that is already read; `options.folder` must be absolute.
core::ExitCode write_submission_index(const IndexOptions& options, const run::Submission& submission);

/// `vrda status`: prints the progress of the tasks of a submission.
struct StatusOptions {
  std::string folder;
  std::string case_name;  ///< print this case's tasks; empty: the only case's, or one line per campaign case
  bool as_json = false;   ///< print all cases and tasks
};

core::ExitCode status_command(const StatusOptions& options);

/// `vrda submit` and `vrda resume`: run the cases of a job or campaign through Slurm or local processes.
struct SubmitOptions {
  std::string job_file;  ///< a job or a campaign
  std::string folder;    ///< empty: results/<job name>
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_shards = 1;  ///< shards per case
  run::SlurmOptions slurm;
  bool is_dry = false;    ///< print scripts and commands, write nothing
  bool is_local = false;  ///< run the tasks now, on this machine
  int n_workers = 0;      ///< concurrent local processes; 0: one per processor
  bool as_json = false;
};

/// Writes the submission's folder and starts all of its tasks. Throws InputError if the folder already
/// contains a submission or a motion model that would be replaced. If Slurm refuses the first job, the folder
/// is removed; if it refuses a later one, the accepted jobs continue and vrda resume submits the rest.
core::ExitCode submit_command(const SubmitOptions& options);

struct ResumeOptions {
  std::string folder;
  run::SlurmOptions slurm;  ///< an empty or 0 option keeps its submitted value
  bool is_dry = false;
  bool is_local = false;
  int n_workers = 0;
  bool as_json = false;
};

/// Starts the missing tasks and prints why. Does not start tasks that Slurm has queued or runs.
core::ExitCode resume_command(const ResumeOptions& options);

/// `vrda task`: the command that each Slurm task or local process of a submission runs.
struct TaskOptions {
  std::string folder;     ///< of the submission
  std::string kind;       ///< "spine", "shard", "merge", "run" or "index"
  std::string case_name;  ///< empty: use `first`
  int first = 1;          ///< number of the case, from 1
  int count = 1;          ///< number of cases that a `run` task solves in sequence
  int shard = 0;
  int n_cpus = 1;
  /// 128 + the signal that ended the task: record that instead of running the task; 0: run it.
  int recorded_exit_code = 0;
};

/// Runs the requested tasks in this process and writes the state of each before and after. Skips a task whose
/// case is finished. Returns the worst exit code; an interruption ends the list. An interruption at the time
/// limit without a solved step is a failure, since a restart would end the same way.
core::ExitCode task_command(const TaskOptions& options);

/// How start_tasks starts the tasks of a submission.
struct StartOptions {
  bool is_dry = false;
  bool is_local = false;
  int n_workers = 0;  ///< concurrent local processes; 0: one per processor
  bool as_json = false;
};

/// Local: returns the worst exit code once all processes have ended. Slurm: prints the submitted jobs. Dry
/// run: prints what would be submitted.
core::ExitCode start_tasks(const std::string& folder, const run::Submission& submission,
                           const run::Work& work, const StartOptions& options);

}  // namespace vrda::app
