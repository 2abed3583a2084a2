#include "run/submission_scenes.hpp"

#include <filesystem>

#include "store/journal.hpp"

namespace vrda::test {
namespace {

namespace fs = std::filesystem;

constexpr std::int32_t n_rows = 7, n_columns = 5;

run::SubmittedCase case_of(const std::string& name, const std::string& output)
{
  run::SubmittedCase c;
  c.spec = {name, "/jobs/" + name + ".toml", "", {"grid.varus={from=-2,to=2,step=1}"}};
  c.output = output;
  c.n_flexion = n_rows;
  c.n_varus = n_columns;
  return c;
}

run::Submission without_cases(std::int32_t n_shards)
{
  run::Submission submission;
  submission.program = "/bin/vrda";
  submission.n_shards = n_shards;
  submission.slurm.time = "10";
  submission.slurm.memory = "200M";
  return submission;
}

}  // namespace

run::Submission one_case(std::int32_t n_shards)
{
  run::Submission submission = without_cases(n_shards);
  submission.cases.push_back(case_of("knee", "knee.h5"));
  return submission;
}

run::Submission campaign(std::int32_t n_cases, std::int32_t n_shards)
{
  run::Submission submission = without_cases(n_shards);
  submission.title = "A study";
  submission.axes = {"subject"};
  for (std::int32_t k = 1; k <= n_cases; ++k) {
    const std::string name = "case-" + std::to_string(k);
    submission.cases.push_back(case_of(name, name + "/" + name + ".h5"));
    submission.cases.back().levels = {name};
  }
  return submission;
}

std::string folder_with(const Scratch& scratch, const run::Submission& submission)
{
  const std::string folder = (scratch.path() / "submission").string();
  for (const std::string& one : {run::scripts_of(folder), run::logs_of(folder), run::tasks_of(folder)})
    fs::create_directories(one);
  run::write_submission(folder, submission);
  return folder;
}

run::TaskState state_of(run::TaskStatus phase, const std::string& slurm_job, const std::string& reason)
{
  run::TaskState state = run::started_now(0);
  state.status = phase;
  state.slurm_job = slurm_job;
  state.reason = reason;
  return state;
}

void write_journal(const std::string& path, const std::vector<std::int32_t>& rows, std::int32_t n_varus,
                   std::int32_t spine_column)
{
  fs::create_directories(fs::path(path).parent_path());
  store::JournalWriter writer = store::JournalWriter::create(path, std::string(64, 'a'));
  for (const std::int32_t i : rows) {
    for (std::int32_t j = 0; j < n_varus; ++j) {
      StepRecord record;
      record.key = {j == spine_column ? StepKind::spine : StepKind::row, i, j};
      record.status = StepStatus::stable;
      writer.append(record);
    }
  }
  writer.close();
}

void write_free_spine(const std::string& path, std::int32_t n_steps)
{
  store::JournalWriter writer = store::JournalWriter::create(path, std::string(64, 'a'));
  for (std::int32_t i = 0; i < n_steps; ++i) {
    StepRecord record;
    record.key = {StepKind::free_spine, i, 0};
    record.status = StepStatus::stable;
    writer.append(record);
  }
  writer.close();
}

}  // namespace vrda::test
