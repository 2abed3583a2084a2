#include "run/submission.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "run/json_fields.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "store/run_files.hpp"

namespace vrda::run {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* format = "vrda submission 1";
constexpr std::array<const char*, 5> kind_names{"spine", "shard", "merge", "run", "index"};

// Invariants of a submission, which a user may have edited.
bool is_valid(const Submission& s)
{
  return s.n_shards >= 1 && s.slurm.cpus >= 1 && !s.cases.empty() &&
         std::all_of(s.cases.begin(), s.cases.end(), [](const SubmittedCase& c) {
           return c.n_flexion >= 1 && c.n_varus >= 1 && c.n_samples >= 0;
         });
}

}  // namespace

// The keys of submission.json (schemas/submission.md), for both directions (json_fields.hpp).
template <typename Fields>
void name_fields(const Fields& fields, SubmittedCase& c)
{
  name_spec_fields(fields, c.spec);
  fields("levels", c.levels);
  fields("output", c.output);
  fields("flexions", c.n_flexion);
  fields("columns", c.n_varus);
  fields.optional("samples", c.n_samples);
}

template <typename Fields>
void name_fields(const Fields& fields, SlurmOptions& s)
{
  fields("partition", s.partition);
  fields("time", s.time);
  fields("memory", s.memory);
  fields("account", s.account);
  fields("qos", s.qos);
  fields("cpus", s.cpus);
  fields("max_parallel", s.max_parallel);
  fields("cases_per_task", s.cases_per_task);
  fields("extra", s.extra);
}

template <typename Fields>
void name_fields(const Fields& fields, Submission& s)
{
  fields("program", s.program);
  fields("title", s.title);
  fields("axes", s.axes);
  fields("shards", s.n_shards);
  fields("slurm", s.slurm);
  fields("cases", s.cases);
}

const char* name_of(TaskKind kind)
{
  return kind_names.at(static_cast<std::size_t>(kind));
}

std::optional<TaskKind> task_kind_of(const std::string& word)
{
  const auto found = std::find(kind_names.begin(), kind_names.end(), word);
  if (found == kind_names.end()) return std::nullopt;
  return static_cast<TaskKind>(found - kind_names.begin());
}

std::string absolute_folder(const std::string& folder)
{
  return fs::absolute(folder + "/").lexically_normal().parent_path().string();
}

std::string output_of(const std::string& folder, const SubmittedCase& submitted)
{
  return (fs::path(folder) / submitted.output).string();
}

const SubmittedCase& case_of(const Submission& submission, const TaskId& task)
{
  return submission.cases.at(static_cast<std::size_t>(task.case_number));
}

std::vector<TaskId> tasks_of_case(const Submission& submission, std::int32_t case_number)
{
  if (submission.n_shards == 1) return {{TaskKind::run, case_number, 0}};
  std::vector<TaskId> tasks{{TaskKind::spine, case_number, 0}};
  for (std::int32_t k = 1; k <= submission.n_shards; ++k) tasks.push_back({TaskKind::shard, case_number, k});
  tasks.push_back({TaskKind::merge, case_number, 0});
  return tasks;
}

std::vector<TaskId> tasks_of(const Submission& submission)
{
  std::vector<TaskId> tasks;
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(submission.cases.size()); ++k) {
    const std::vector<TaskId> of_case = tasks_of_case(submission, k);
    tasks.insert(tasks.end(), of_case.begin(), of_case.end());
  }
  if (submission.has_index()) tasks.push_back({TaskKind::index, -1, 0});
  return tasks;
}

bool is_case_complete(const std::string& folder, const SubmittedCase& submitted)
{
  const std::string output = output_of(folder, submitted);
  std::error_code ignored;
  return fs::exists(output, ignored) && !fs::exists(case_file_of(output), ignored) &&
         !fs::exists(store::journal_of(output), ignored);
}

std::string text_of(const TaskId& task, const Submission& submission)
{
  const std::string kind = name_of(task.kind);
  if (task.kind != TaskKind::shard) return kind;
  return kind + " " + std::to_string(task.shard) + " of " + std::to_string(submission.n_shards);
}

std::string full_text_of(const TaskId& task, const Submission& submission)
{
  const bool has_name = submission.has_index() && task.case_number >= 0;
  return (has_name ? case_of(submission, task).spec.name + " " : "") + text_of(task, submission);
}

std::string file_stem_of(const TaskId& task, const Submission& submission)
{
  if (task.kind == TaskKind::index) return "index";
  const std::string& name = case_of(submission, task).spec.name;
  if (task.kind != TaskKind::shard) return name + "." + name_of(task.kind);
  return name + ".shard-" + std::to_string(task.shard) + "-of-" + std::to_string(submission.n_shards);
}

void write_submission(const std::string& folder, const Submission& submission)
{
  Json json = {{"format", format}};
  json.update(Json(submission));
  const std::string path = submission_file_of(folder);
  try {
    write_atomically(path, {json.dump(1), "\n"});
  } catch (const Json::exception&) {
    throw InputError({path, "", "a path or name that is not UTF-8", "paths in UTF-8"});
  }
}

Submission read_submission(const std::string& folder)
{
  const std::string path = submission_file_of(folder);
  const std::string wanted = "the folder of a submission, created by vrda submit";
  const std::optional<std::string> text = read_text_file(path);
  if (!text) throw InputError({path, "", "no file", wanted});
  const core::JsonFile file(path, *text, wanted);
  if (file.text("format") != format) file.refuse("format", file.text("format"), format);
  const auto submission = value_in<Submission>(file, path);
  if (is_valid(submission)) return submission;
  throw InputError({path, "", "content that is not a submission", wanted});
}

std::int32_t case_named(const Submission& submission, const std::string& name)
{
  std::vector<std::string> names;
  for (const SubmittedCase& c : submission.cases) {
    if (c.spec.name == name) return static_cast<std::int32_t>(names.size());
    names.push_back(c.spec.name);
  }
  throw InputError({"--case", "", name.empty() ? "nothing" : name,
                    "a case of the submission; the nearest is " + nearest_word(name, names)});
}

}  // namespace vrda::run
