/// The commands that make many cases by many tasks.
#pragma once

#include <string>
#include <vector>

#include "cluster/campaign.hpp"
#include "cluster/cost.hpp"
#include "cluster/jobs.hpp"
#include "cluster/submission.hpp"
#include "load/case.hpp"
#include "sweep/sweep.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct PlanOptions {
  std::string job_file;  ///< or a campaign
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_shards = 1;
  bool as_json = false;
};

/// Solves nothing. Throws InputError for the first case that is wrong.
ExitCode plan_command(const PlanOptions& options);

/// Looks at every case of a campaign before anything is solved, and estimates what it will take.
struct PlannedCase {
  CampaignCase campaign_case;
  Case job_case;  ///< without bodies, survey and job text
  SweepPlan plan;
  CaseSize size;
  CaseCost cost;
  std::string same_as;        ///< an earlier case that gives the same motion; empty: none
  std::string same_steps_as;  ///< an earlier one that only scaling tells from this: one journal serves both
};

/// Reads every job, and each set of meshes once. Throws InputError for the first case that is wrong, named in
/// the message where there are several. Cost: a few ms a case, and loading each set of meshes.
std::vector<PlannedCase> planned_cases(const Campaign& campaign);

/// `vrda index`: one table of the results of a submission.
struct IndexOptions {
  std::string folder;  ///< of a submission
  bool as_json = false;
  int n_processes = 0;  ///< that read models; 0: as many as there are processors
};

/// Writes index.csv, index.h5 and index.times.csv there and prints their paths. Cases that are not done are
/// rows too. Throws InputError where there is no submission or no room.
ExitCode index_command(const IndexOptions& options);

/// The same of a submission that is read already, its folder absolute.
ExitCode write_index_of(const IndexOptions& options, const Submission& submission);

/// `vrda status`: how far the tasks of a submission are.
struct StatusOptions {
  std::string folder;
  std::string case_name;  ///< its tasks; empty: those of the only case, or a line a case of a campaign
  bool as_json = false;   ///< everything
};

ExitCode status_command(const StatusOptions& options);

/// `vrda submit` and `vrda resume`: the cases of a job or campaign, by Slurm or by local processes.
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

/// `vrda task`: what each Slurm task or local process of a submission runs.
struct TaskOptions {
  std::string folder;     ///< of the submission
  std::string kind;       ///< "spine", "shard", "merge", "run" or "index"
  std::string case_name;  ///< empty: by number
  int first = 1;          ///< number of the case, from 1
  int count = 1;          ///< cases of a `run`, one after the other
  int shard = 0;
  int n_cpus = 1;
  /// 128 and the number of the signal that ended the task: note that down instead of running it; 0: run it.
  int ended = 0;
};

/// Runs the tasks asked for, in this process, and leaves the state of each before and after. A task whose
/// case is made already is done. The worst of their exit codes; an interruption ends the list. An
/// interruption at the time limit that solved nothing is a failure: the next start would do no better.
ExitCode task_command(const TaskOptions& options);

/// Starts tasks of a submission, the way that was asked for.
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
