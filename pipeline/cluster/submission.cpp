#include "cluster/submission.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/nearest_word.hpp"
#include "core/whole_file.hpp"
#include "journal/run_files.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* format = "vrda submission 1";
constexpr std::array<const char*, 5> kind_names{"spine", "shard", "merge", "run", "index"};

std::string beside(const std::string& folder, const char* name)
{
  return (fs::path(folder) / name).string();
}

Json json_of(const SubmittedCase& c)
{
  return {{"name", c.spec.name},     {"job", c.spec.job_file}, {"data", c.spec.data_directory},
          {"set", c.spec.overrides}, {"levels", c.levels},     {"output", c.output},
          {"flexions", c.n_flexion}, {"columns", c.n_varus}};
}

SubmittedCase case_of(const Json& json)
{
  SubmittedCase c;
  c.spec = {json.at("name"), json.at("job"), json.at("data"), json.at("set")};
  c.levels = json.at("levels").get<std::vector<std::string>>();
  c.output = json.at("output");
  c.n_flexion = json.at("flexions");
  c.n_varus = json.at("columns");
  return c;
}

Json json_of(const SlurmOptions& s)
{
  return {{"partition", s.partition},
          {"time", s.time},
          {"memory", s.memory},
          {"account", s.account},
          {"qos", s.qos},
          {"cpus", s.cpus},
          {"max_parallel", s.max_parallel},
          {"cases_per_task", s.cases_per_task},
          {"extra", s.extra}};
}

SlurmOptions slurm_of(const Json& json)
{
  SlurmOptions s;
  s.partition = json.at("partition");
  s.time = json.at("time");
  s.memory = json.at("memory");
  s.account = json.at("account");
  s.qos = json.at("qos");
  s.cpus = json.at("cpus");
  s.max_parallel = json.at("max_parallel");
  s.cases_per_task = json.at("cases_per_task");
  s.extra = json.at("extra").get<std::vector<std::string>>();
  return s;
}

Submission submission_of(const Json& json)
{
  Submission s;
  s.program = json.at("program");
  s.title = json.at("title");
  s.axes = json.at("axes").get<std::vector<std::string>>();
  s.n_shards = json.at("shards");
  s.slurm = slurm_of(json.at("slurm"));
  for (const Json& c : json.at("cases")) s.cases.push_back(case_of(c));
  return s;
}

// What the program relies on, whoever edited the file.
bool is_sound(const Submission& s)
{
  return s.n_shards >= 1 && s.slurm.cpus >= 1 && !s.cases.empty() &&
         std::all_of(s.cases.begin(), s.cases.end(),
                     [](const SubmittedCase& c) { return c.n_flexion >= 1 && c.n_varus >= 1; });
}

}  // namespace

const char* name_of(TaskKind kind)
{
  return kind_names.at(static_cast<std::size_t>(kind));
}

TaskKind task_kind_of(const std::string& word)
{
  const auto found = std::find(kind_names.begin(), kind_names.end(), word);
  if (found != kind_names.end()) return static_cast<TaskKind>(found - kind_names.begin());
  throw InputError({"--kind", "", word.empty() ? "nothing" : word, "spine, shard, merge, run or index"});
}

std::string submission_file_of(const std::string& folder)
{
  return beside(folder, "submission.json");
}
std::string submitted_file_of(const std::string& folder)
{
  return beside(folder, "submitted.jsonl");
}
std::string scripts_of(const std::string& folder)
{
  return beside(folder, "scripts");
}
std::string logs_of(const std::string& folder)
{
  return beside(folder, "logs");
}
std::string tasks_of(const std::string& folder)
{
  return beside(folder, "tasks");
}
std::string output_of(const std::string& folder, const SubmittedCase& submitted)
{
  return (fs::path(folder) / submitted.output).string();
}

bool is_made(const std::string& folder, const SubmittedCase& submitted)
{
  const std::string output = output_of(folder, submitted);
  std::error_code ignored;
  return fs::exists(output, ignored) && !fs::exists(case_file_of(output), ignored) &&
         !fs::exists(journal_of(output), ignored);
}

std::string text_of(const TaskId& task, const Submission& submission)
{
  const std::string kind = name_of(task.kind);
  if (task.kind != TaskKind::shard) return kind;
  return kind + " " + std::to_string(task.shard) + " of " + std::to_string(submission.n_shards);
}

std::string file_stem_of(const TaskId& task, const Submission& submission)
{
  if (task.kind == TaskKind::index) return "index";
  const std::string& name = submission.cases.at(static_cast<std::size_t>(task.case_number)).spec.name;
  if (task.kind != TaskKind::shard) return name + "." + name_of(task.kind);
  return name + ".shard-" + std::to_string(task.shard) + "-of-" + std::to_string(submission.n_shards);
}

void write_submission(const std::string& folder, const Submission& submission)
{
  Json cases = Json::array();
  for (const SubmittedCase& c : submission.cases) cases.push_back(json_of(c));
  const Json json = {
      {"format", format},        {"program", submission.program}, {"title", submission.title},
      {"axes", submission.axes}, {"shards", submission.n_shards}, {"slurm", json_of(submission.slurm)},
      {"cases", cases}};
  const std::string path = submission_file_of(folder);
  try {
    write_whole(path, {json.dump(1), "\n"});
  } catch (const Json::exception&) {
    throw InputError({path, "", "a path or name with bytes that are no UTF-8", "paths in UTF-8"});
  }
}

Submission read_submission(const std::string& folder)
{
  const std::string path = submission_file_of(folder);
  const std::string wanted = "the folder of a submission, which vrda submit makes";
  const std::optional<std::string> text = text_of_file(path);
  if (!text) throw InputError({path, "", "no file", wanted});
  try {
    const Json json = Json::parse(*text);
    const std::string found = json.at("format");
    if (found != format) throw InputError({path, "format", found, format});
    Submission submission = submission_of(json);
    if (is_sound(submission)) return submission;
  } catch (const Json::exception&) {
  }
  throw InputError({path, "", "something that is no submission", wanted});
}

std::int32_t case_named(const Submission& submission, const std::string& name)
{
  std::vector<std::string> names;
  for (const SubmittedCase& c : submission.cases) {
    if (c.spec.name == name) return static_cast<std::int32_t>(names.size());
    names.push_back(c.spec.name);
  }
  throw InputError({"--case", "", name.empty() ? "nothing" : name,
                    "a case of the submission, perhaps " + nearest_word(name, names)});
}

}  // namespace vrda
