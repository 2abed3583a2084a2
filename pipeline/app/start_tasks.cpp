// Starts the tasks of a submission that have no result: as Slurm jobs, as local processes, or a plan only.
#include "app/cluster_commands.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "cluster/local_run.hpp"
#include "cluster/slurm.hpp"
#include "cluster/slurm_scripts.hpp"
#include "console/console.hpp"
#include "core/error.hpp"
#include "job_run/summary.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json)
{
  return documents::json_text(json, 2);
}

console::ExitCode run_here(const std::string& folder, const cluster::Submission& submission,
                           const cluster::Work& work, const StartOptions& options)
{
  const int n_workers = job_run::thread_count_or_all(options.n_workers);
  cluster::LocalOptions local;
  local.n_workers = n_workers;
  local.n_cpus = std::max({1, submission.slurm.cpus, job_run::thread_count_or_all(0) / n_workers});
  local.is_stop_requested = console::is_interrupted;
  local.report = console::log_info;
  console::install_signal_handlers();
  const cluster::LocalOutcome outcome = cluster::run_locally(
      folder, submission, cluster::jobs_of_work(submission, work, cluster::no_limits), local);
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
    console::log_warning(std::to_string(outcome.n_failed) + " tasks failed; " +
                         std::to_string(outcome.n_skipped) +
                         " tasks that depend on them did not start: see vrda status " + folder);
  }
  if (!outcome.is_interrupted) return static_cast<console::ExitCode>(outcome.worst_code);
  console::log_info("interrupted; to resume: vrda resume " + folder + " --local");
  return console::ExitCode::interrupted;
}

console::ExitCode print_plan(const std::string& folder, const cluster::Submission& submission,
                             const cluster::Work& work)
{
  cluster::SlurmLimits limits;
  try {
    limits = cluster::query_limits();
  } catch (const InputError& error) {
    console::log_warning(std::string(error.what()) + "; using Slurm's defaults");
  }
  const std::vector<cluster::PlannedJob> jobs = cluster::jobs_of_work(submission, work, limits);
  std::set<cluster::TaskKind> kinds;
  for (const cluster::PlannedJob& job : jobs) kinds.insert(job.kind);
  for (const cluster::TaskKind kind : kinds) {
    std::printf("==> scripts/%s <==\n%s\n", cluster::script_name_of(kind).c_str(),
                cluster::script_of(kind, folder, submission).c_str());
  }
  std::printf("==> commands <==\n%s", cluster::sbatch_lines(folder, submission, jobs).c_str());
  return console::ExitCode::done;
}

void print_tasks(const cluster::Submission& submission, const cluster::Work& work)
{
  for (const cluster::PlannedJob& job : cluster::jobs_of_work(submission, work, cluster::no_limits)) {
    for (const cluster::TaskId& task : cluster::tasks_of(submission, job))
      std::printf("%s\n", cluster::full_text_of(task, submission).c_str());
  }
}

Json json_of(const cluster::Submission& submission, const cluster::SubmittedJob& submitted)
{
  const cluster::PlannedJob& job = submitted.job;
  const cluster::TaskId task{job.kind, job.case_number, 0};
  const Json name = job.case_number < 0 ? Json() : Json(cluster::case_of(submission, task).spec.name);
  return {{"id", submitted.id},
          {"kind", cluster::name_of(job.kind)},
          {"case", name},
          {"array", job.numbers.empty() ? Json() : Json(cluster::ranges_text(job.numbers))}};
}

}  // namespace

console::ExitCode start_tasks(const std::string& folder, const cluster::Submission& submission,
                              const cluster::Work& work, const StartOptions& options)
{
  if (options.is_dry && options.is_local) {
    print_tasks(submission, work);
    return console::ExitCode::done;
  }
  if (options.is_dry) return print_plan(folder, submission, work);
  if (options.is_local) return run_here(folder, submission, work, options);
  const std::vector<cluster::PlannedJob> jobs =
      cluster::jobs_of_work(submission, work, cluster::query_limits());
  cluster::write_scripts(folder, submission, jobs);
  const std::vector<cluster::SubmittedJob> submitted = cluster::submit_jobs(folder, submission, jobs);
  if (!options.as_json) {
    for (const std::string& line : cluster::lines_of(submission, submitted))
      std::printf("%s\n", line.c_str());
    return console::ExitCode::done;
  }
  Json list = Json::array();
  for (const cluster::SubmittedJob& job : submitted) list.push_back(json_of(submission, job));
  std::printf("%s\n", dumped({{"folder", folder}, {"jobs", list}}).c_str());
  return console::ExitCode::done;
}

}  // namespace vrda::app
