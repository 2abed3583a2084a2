/// A folder in which the cases of a job or of a campaign are made by many tasks (schemas/submission.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cluster/case_spec.hpp"

namespace vrda {

/// What a task does: a whole case is made by `run`, or by `spine`, every `shard`, then `merge`.
enum class TaskKind { spine, shard, merge, run, index };

const char* name_of(TaskKind kind);
/// Throws InputError whose file is "--kind".
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

  bool operator==(const SubmittedCase&) const = default;
};

/// What Slurm is asked for, each task alike. Empty: the cluster's own default.
struct SlurmOptions {
  std::string partition;
  std::string time;    ///< as sbatch takes it: "30", "2:00:00", "1-12"
  std::string memory;  ///< "500M"
  std::string account;
  std::string qos;
  std::int32_t cpus = 1;            ///< a task
  std::int32_t max_parallel = 0;    ///< tasks of one array at once; 0: no limit
  std::int32_t cases_per_task = 0;  ///< of a campaign without shards; 0: as few as Slurm takes
  std::vector<std::string> extra;   ///< further options of sbatch, "--constraint=avx2"

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
  /// A table of the cases is the last thing made.
  bool has_index() const { return !axes.empty() || cases.size() > 1; }
};

/// Absolute, without a slash at its end.
std::string absolute_folder(const std::string& folder);

/// What stands in the submission's folder, which is absolute.
// clang-format off
inline std::string submission_file_of(const std::string& folder) { return folder + "/submission.json"; }
inline std::string submitted_file_of(const std::string& folder) { return folder + "/submitted.jsonl"; }
inline std::string scripts_of(const std::string& folder) { return folder + "/scripts"; }
inline std::string logs_of(const std::string& folder) { return folder + "/logs"; }
inline std::string tasks_of(const std::string& folder) { return folder + "/tasks"; }
// clang-format on
/// Absolute where `folder` is.
std::string output_of(const std::string& folder, const SubmittedCase& submitted);

/// The tasks that make one case, in the order in which they need each other: `run`; or `spine`, every
/// `shard`, `merge`.
std::vector<TaskId> tasks_of_case(const Submission& submission, std::int32_t case_number);
/// Those of all cases, and the index where there is one.
std::vector<TaskId> tasks_of(const Submission& submission);
/// Of any task but the index.
const SubmittedCase& case_of(const Submission& submission, const TaskId& task);

/// Whether the case's motion model stands and nothing of its making is left to be cleared up.
bool is_made(const std::string& folder, const SubmittedCase& submitted);

/// "spine", "shard 3 of 8", "index"; the case is not named.
std::string text_of(const TaskId& task, const Submission& submission);
/// The same behind the case's name where there are several: "knee shard 3 of 8".
std::string full_text_of(const TaskId& task, const Submission& submission);
/// "<case>.shard-3-of-8": what its state file and its log are called.
std::string file_stem_of(const TaskId& task, const Submission& submission);

/// Whole or not at all. Throw InputError naming the file; a path of no UTF-8 is refused, since it could not
/// be read back.
void write_submission(const std::string& folder, const Submission& submission);
Submission read_submission(const std::string& folder);

/// The case of that name; InputError whose file is "--case" names the nearest one.
std::int32_t case_named(const Submission& submission, const std::string& name);

}  // namespace vrda
