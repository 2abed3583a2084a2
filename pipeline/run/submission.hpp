/// A submission: a folder in which tasks compute the cases of a job or campaign (schemas/submission.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "run/case_spec.hpp"

namespace vrda::run {

/// Kinds of tasks: a case is computed by `run`, or by `spine`, every `shard`, then `merge`.
enum class TaskKind { spine, shard, merge, run, index };

const char* name_of(TaskKind kind);
/// Empty for an unknown word.
std::optional<TaskKind> task_kind_of(const std::string& word);

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

struct Submission {
  std::string program;  ///< absolute path of vrda, as seen by every node
  std::string title;
  std::vector<std::string> axes;  ///< empty for a single job
  std::int32_t n_shards = 1;      ///< of each case
  std::vector<SubmittedCase> cases;
  SlurmOptions slurm;

  bool operator==(const Submission&) const = default;
  /// Whether a table of the cases is written at the end.
  bool has_index() const { return !axes.empty() || cases.size() > 1; }
};

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

}  // namespace vrda::run
