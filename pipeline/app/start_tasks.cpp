// Starts the tasks of a submission that have no result: as Slurm jobs, as local processes, or a plan only.
#include "app/cluster_commands.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "core/console.hpp"
#include "core/text.hpp"
#include "run/local_run.hpp"
#include "run/run_output.hpp"
#include "run/slurm.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json)
{
  return core::json_text(json, 2);
}

core::ExitCode run_here(const std::string& folder, const run::Submission& submission, const run::Work& work,
                        const StartOptions& options)
{
  const int n_workers = run::thread_count_or_all(options.n_workers);
  run::LocalOptions local;
  local.n_workers = n_workers;
  local.n_cpus = std::max({1, submission.slurm.cpus, run::thread_count_or_all(0) / n_workers});
  local.is_stop_requested = core::is_interrupted;
  local.report = core::log_info;
  core::install_signal_handlers();
  const run::LocalOutcome outcome =
      run::run_locally(folder, submission, run::jobs_of_work(submission, work, run::no_limits), local);
  if (options.as_json) {
    std::printf("%s\n", dumped({{"folder", folder},
                                {"done", outcome.n_done},
                                {"failed", outcome.n_failed},
                                {"left_out", outcome.n_skipped},
                                {"interrupted", outcome.is_interrupted}})
                            .c_str());
  } else {
    std::printf("%s\n", folder.c_str());
  }
  if (outcome.n_failed > 0) {
    core::log_warning(std::to_string(outcome.n_failed) + " tasks failed; " +
                      std::to_string(outcome.n_skipped) +
                      " tasks that depend on them did not start: see vrda status " + folder);
  }
  if (!outcome.is_interrupted) return static_cast<core::ExitCode>(outcome.worst_code);
  core::log_info("interrupted; to resume: vrda resume " + folder + " --local");
  return core::ExitCode::interrupted;
}

core::ExitCode print_plan(const std::string& folder, const run::Submission& submission, const run::Work& work)
{
  run::SlurmLimits limits;
  try {
    limits = run::query_limits();
  } catch (const InputError& error) {
    core::log_warning(std::string(error.what()) + "; using Slurm's defaults");
  }
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission, work, limits);
  std::set<run::TaskKind> kinds;
  for (const run::PlannedJob& job : jobs) kinds.insert(job.kind);
  for (const run::TaskKind kind : kinds) {
    std::printf("==> scripts/%s <==\n%s\n", run::script_name_of(kind).c_str(),
                run::script_of(kind, folder, submission).c_str());
  }
  std::printf("==> commands <==\n%s", run::sbatch_lines(folder, submission, jobs).c_str());
  return core::ExitCode::done;
}

void print_tasks(const run::Submission& submission, const run::Work& work)
{
  for (const run::PlannedJob& job : run::jobs_of_work(submission, work, run::no_limits)) {
    for (const run::TaskId& task : run::tasks_of(submission, job))
      std::printf("%s\n", run::full_text_of(task, submission).c_str());
  }
}

Json json_of(const run::Submission& submission, const run::SubmittedJob& submitted)
{
  const run::PlannedJob& job = submitted.job;
  const run::TaskId task{job.kind, job.case_number, 0};
  const Json name = job.case_number < 0 ? Json() : Json(run::case_of(submission, task).spec.name);
  return {{"id", submitted.id},
          {"kind", core::name_of(job.kind)},
          {"case", name},
          {"array", job.numbers.empty() ? Json() : Json(run::ranges_text(job.numbers))}};
}

}  // namespace

core::ExitCode start_tasks(const std::string& folder, const run::Submission& submission,
                           const run::Work& work, const StartOptions& options)
{
  if (options.is_dry && options.is_local) {
    print_tasks(submission, work);
    return core::ExitCode::done;
  }
  if (options.is_dry) return print_plan(folder, submission, work);
  if (options.is_local) return run_here(folder, submission, work, options);
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission, work, run::query_limits());
  run::write_scripts(folder, submission, jobs);
  const std::vector<run::SubmittedJob> submitted = run::submit_jobs(folder, submission, jobs);
  if (!options.as_json) {
    for (const std::string& line : run::lines_of(submission, submitted)) std::printf("%s\n", line.c_str());
    return core::ExitCode::done;
  }
  Json list = Json::array();
  for (const run::SubmittedJob& job : submitted) list.push_back(json_of(submission, job));
  std::printf("%s\n", dumped({{"folder", folder}, {"jobs", list}}).c_str());
  return core::ExitCode::done;
}

}  // namespace vrda::app
