/// A submission: a folder in which tasks compute the cases of a job or campaign (schemas/submission.md).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "model/step_record.hpp"
#include "run/campaign.hpp"
#include "solve/sweep.hpp"
#include "store/journal.hpp"

namespace vrda::run {

/// Kinds of tasks: a case is computed by `run`, or by `spine`, every `shard`, then `merge`.
enum class TaskKind { spine, shard, merge, run, index };
inline constexpr Named<TaskKind> task_kind_names[] = {{TaskKind::spine, "spine"},
                                                      {TaskKind::shard, "shard"},
                                                      {TaskKind::merge, "merge"},
                                                      {TaskKind::run, "run"},
                                                      {TaskKind::index, "index"}};
constexpr const auto& names_of(TaskKind)
{
  return task_kind_names;
}

/// One task of a submission.
struct TaskId {
  TaskKind kind = TaskKind::run;
  std::int32_t case_number = -1;  ///< into Submission::cases; -1 for `index`
  std::int32_t shard = 0;         ///< from 1 for `shard`, else 0

  // clang-tidy 14 takes the generated comparison with 0 for a null pointer.
  auto operator<=>(const TaskId&) const = default;  // NOLINT(modernize-use-nullptr)
};

struct SubmittedCase {
  CaseSpec spec;
  std::vector<std::string> levels;  ///< [axes]
  std::string output;               ///< motion model, relative to the submission's folder
  std::int32_t n_flexion = 0;       ///< rows of the grid
  std::int32_t n_varus = 0;
  std::int32_t n_samples = 0;  ///< of an uncertain job

  bool operator==(const SubmittedCase&) const = default;
};
constexpr auto fields_of(const SubmittedCase*)
{
  return std::tuple{Field{"", &SubmittedCase::spec},
                    Field{"levels", &SubmittedCase::levels},
                    Field{"output", &SubmittedCase::output},
                    Field{"flexions", &SubmittedCase::n_flexion},
                    Field{"columns", &SubmittedCase::n_varus},
                    Field{"samples", &SubmittedCase::n_samples, unit::one, "", Presence::unless_new}};
}

/// sbatch options, equal for all tasks. Empty: the cluster's default.
struct SlurmOptions {
  std::string partition;
  std::string time;    ///< in sbatch's format: "30", "2:00:00", "1-12"
  std::string memory;  ///< "500M"
  std::string account;
  std::string qos;
  std::int32_t cpus = 1;          ///< per task
  std::int32_t max_parallel = 0;  ///< concurrent tasks of one array; 0: no limit
  std::int32_t cases_per_task =
      0;  ///< of a campaign without shards; 0: smallest number that fits Slurm's limits
  std::vector<std::string> extra;  ///< further options of sbatch, "--constraint=avx2"

  bool operator==(const SlurmOptions&) const = default;
};
constexpr auto fields_of(const SlurmOptions*)
{
  using O = SlurmOptions;
  return std::tuple{Field{"partition", &O::partition},
                    Field{"time", &O::time},
                    Field{"memory", &O::memory},
                    Field{"account", &O::account},
                    Field{"qos", &O::qos},
                    Field{"cpus", &O::cpus},
                    Field{"max_parallel", &O::max_parallel},
                    Field{"cases_per_task", &O::cases_per_task},
                    Field{"extra", &O::extra}};
}

struct Submission {
  std::string program;  ///< absolute path of vrda, as seen by every node
  std::string title;
  std::vector<std::string> axes;  ///< empty for a single job
  std::int32_t n_shards = 1;      ///< of each case
  std::vector<SubmittedCase> cases;
  SlurmOptions slurm;
  bool permits_missing_locks = false;  ///< its tasks go on without locks (--no-lock)

  bool operator==(const Submission&) const = default;
  /// Whether a table of the cases is written at the end.
  bool has_index() const { return !axes.empty() || cases.size() > 1; }
};
/// The keys of submission.json (schemas/submission.md).
constexpr auto fields_of(const Submission*)
{
  return std::tuple{
      Field{"program", &Submission::program},
      Field{"title", &Submission::title},
      Field{"axes", &Submission::axes},
      Field{"shards", &Submission::n_shards},
      Field{"slurm", &Submission::slurm},
      Field{"no_lock", &Submission::permits_missing_locks, unit::none, "", Presence::unless_new},
      Field{"cases", &Submission::cases}};
}

/// Absolute path without a trailing slash.
std::string absolute_folder(const std::string& folder);

/// Files in the submission's folder, which is absolute.
// clang-format off
inline std::string submission_file_of(const std::string& folder) { return folder + "/submission.json"; }
inline std::string submitted_file_of(const std::string& folder) { return folder + "/submitted.jsonl"; }
inline std::string scripts_of(const std::string& folder) { return folder + "/scripts"; }
inline std::string logs_of(const std::string& folder) { return folder + "/logs"; }
inline std::string tasks_of(const std::string& folder) { return folder + "/tasks"; }
// clang-format on
/// Absolute if `folder` is.
std::string output_of(const std::string& folder, const SubmittedCase& submitted);

/// The tasks of one case in dependency order: `run`; or `spine`, every `shard`, `merge`.
std::vector<TaskId> tasks_of_case(const Submission& submission, std::int32_t case_number);
/// The tasks of all cases, and the index task if there is one.
std::vector<TaskId> tasks_of(const Submission& submission);
/// The case of any task except the index.
const SubmittedCase& case_of(const Submission& submission, const TaskId& task);

/// Whether the case's motion model exists and all intermediate files have been removed.
bool is_case_complete(const std::string& folder, const SubmittedCase& submitted);

/// "spine", "shard 3 of 8", "index"; without the case's name.
std::string text_of(const TaskId& task, const Submission& submission);
/// The same after the case's name if there are several cases: "knee shard 3 of 8".
std::string full_text_of(const TaskId& task, const Submission& submission);
/// "<case>.shard-3-of-8": stem of its state file and its log.
std::string file_stem_of(const TaskId& task, const Submission& submission);

/// Written atomically. Throw InputError naming the file, also for paths that are not UTF-8.
void write_submission(const std::string& folder, const Submission& submission);
Submission read_submission(const std::string& folder);

/// Index of the case with that name. Throws InputError whose file is "--case", naming the nearest one.
std::int32_t case_named(const Submission& submission, const std::string& name);

// Remaining tasks as Slurm jobs and job arrays with dependencies; local processes use the same jobs.

/// Parses "3/8". Throws InputError whose file is "--shard".
store::Shard shard_of(const std::string& text);

/// Rows of a shard, round-robin: i with i % count == number - 1. Empty for the last shards if there are more
/// shards than rows.
std::vector<std::int32_t> rows_of(const store::Shard& shard, std::int32_t n_rows);

/// Remaining tasks of one case: `run` only, or the missing of spine and shards followed by a merge.
struct CaseWork {
  std::int32_t case_number = 0;
  bool needs_spine = false;
  std::vector<std::int32_t> shards;  ///< ascending
  bool needs_run = false;
  /// Slurm ids of active jobs on which the shards or the merge depend.
  std::vector<std::string> active_spine_jobs;
  std::vector<std::string> active_shard_jobs;
};

struct Work {
  std::vector<CaseWork> cases;
  bool needs_index = false;
  std::vector<std::string> active_case_jobs;  ///< Slurm ids of other active jobs on which the index depends

  bool is_empty() const { return cases.empty() && !needs_index; }
};

/// All tasks of a new submission.
Work all_work(const Submission& submission);

/// Slurm's limits, with its defaults.
struct SlurmLimits {
  std::int32_t max_array_size = 1001;  ///< an array's largest number is one less
  std::int32_t max_job_count = 10000;  ///< jobs in the queue; each array task counts
};

/// One sbatch command: a job or a job array.
struct PlannedJob {
  TaskKind kind = TaskKind::run;
  std::int32_t case_number = -1;      ///< for spine, shard and merge
  std::vector<std::int32_t> numbers;  ///< array task numbers, ascending; empty: no array
  std::int32_t offset = 0;            ///< of `run`: task t starts at case offset + (t - 1) * per_task
  std::int32_t per_task = 1;
  std::vector<std::size_t> after;      ///< dependencies: earlier jobs of the list
  std::vector<std::string> after_ids;  ///< dependencies: ids of active jobs

  bool operator==(const PlannedJob&) const = default;
};
/// Without the dependencies.
constexpr auto fields_of(const PlannedJob*)
{
  return std::tuple{Field{"kind", &PlannedJob::kind}, Field{"case", &PlannedJob::case_number},
                    Field{"array", &PlannedJob::numbers}, Field{"offset", &PlannedJob::offset},
                    Field{"per_task", &PlannedJob::per_task}};
}

/// Limits of local runs.
inline constexpr SlurmLimits no_limits{1'000'000'000, 2'000'000'000};

/// The jobs in submission order. Throws InputError naming option and fitting value beyond Slurm's limits.
std::vector<PlannedJob> jobs_of_work(const Submission& submission, const Work& work,
                                     const SlurmLimits& limits);

/// Cases per array task: the option's value, or the smallest number for which tasks fill half the queue.
std::int32_t cases_per_task(const Submission& submission, const SlurmLimits& limits);

/// "1-3,5": sbatch's notation of ascending numbers.
std::string ranges_text(const std::vector<std::int32_t>& numbers);

/// Log file of a `run` job's task `number`, which may also be an sbatch pattern.
std::string log_of_runs(std::int32_t offset, const std::string& number);

/// The tasks of array task `number` of a job (0: job without an array); for `run` one per case.
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job, std::int32_t number);
/// The tasks of all its array tasks.
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job);

// Collects the steps of one job from many journals and finds missing and duplicate ones.

struct CollectedSteps {
  std::map<StepKey, StepRecord> steps;
  std::int32_t n_duplicates = 0;             ///< steps found more than once, with the same bytes
  std::set<std::int32_t> duplicate_rows;     ///< their flexion indices
  std::set<std::string> duplicate_journals;  ///< the journals that contain them
  std::vector<std::string> warnings;         ///< one message for each journal with a damaged end
};

/// Reads all journals. `key`: the job's (solve::fingerprint_of), which each journal must have. Throws
/// InputError with the file for a journal of another job, and with both files if a step has two different
/// results.
CollectedSteps collect_steps(const std::vector<std::string>& journals, const std::string& key);

/// The missing cells of a row that has some results, for example of an interrupted shard.
struct IncompleteRow {
  std::int32_t row = 0;
  std::vector<std::int32_t> columns;  ///< varus indices without a result
};

/// The steps without a result.
struct MissingSteps {
  bool is_spine_complete = false;
  std::vector<std::int32_t>
      rows;  ///< flexion indices of incomplete rows; all rows if the spine is incomplete
  std::vector<IncompleteRow> incomplete_rows;  ///< those of `rows` that have some results
  std::int32_t n_attitudes = 0;                ///< cells of the grid without a result

  bool is_empty() const { return is_spine_complete && rows.empty(); }
};

/// Follows the seeding graph of `plan` through `steps`, for the rows `plan.rows`; absent: all.
MissingSteps missing_steps(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// The sweep result of a complete set of steps; solves none.
solve::SweepResult replay_sweep(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps);

/// "0, 10 and 20 to 90": the angles with these indices, ascending, in degrees.
std::string angles_text(const std::vector<std::int32_t>& indices, const std::vector<double>& angles_deg);

/// "no result for 15 of 110 attitudes, at flexion 0 and 30, and at flexion 60 of varus -2 to 4"; empty if
/// every row is complete.
std::string missing_text(const MissingSteps& missing, const std::vector<double>& flexion_deg,
                         const std::vector<double>& varus_deg);

}  // namespace vrda::run
