#include "app/cluster_commands.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "cluster/local_run.hpp"
#include "cluster/slurm.hpp"
#include "cluster/slurm_scripts.hpp"
#include "core/error.hpp"
#include "run/summary.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json)
{
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

ExitCode run_here(const std::string& folder, const Submission& submission, const Work& work,
                  const StartOptions& options)
{
  const int n_workers = threads_or_all(options.n_workers);
  LocalOptions local;
  local.n_workers = n_workers;
  local.n_cpus = std::max({1, submission.slurm.cpus, threads_or_all(0) / n_workers});
  local.is_stopped = is_interrupted;
  local.tell = say;
  watch_for_interrupts();
  const LocalOutcome outcome =
      run_locally(folder, submission, jobs_of_work(submission, work, no_limits), local);
  if (options.as_json) {
    std::printf("%s\n", dumped({{"folder", folder},
                                {"done", outcome.n_done},
                                {"failed", outcome.n_failed},
                                {"left_out", outcome.n_left_out},
                                {"interrupted", outcome.is_interrupted}})
                            .c_str());
  } else {
    std::printf("%s\n", folder.c_str());
  }
  if (outcome.n_failed > 0) {
    warn(std::to_string(outcome.n_failed) + " tasks failed; " + std::to_string(outcome.n_left_out) +
         " tasks that depend on them did not start: see vrda status " + folder);
  }
  if (!outcome.is_interrupted) return static_cast<ExitCode>(outcome.worst_code);
  say("interrupted; to resume: vrda resume " + folder + " --local");
  return ExitCode::interrupted;
}

ExitCode print_plan(const std::string& folder, const Submission& submission, const Work& work)
{
  SlurmLimits limits;
  try {
    limits = ask_limits();
  } catch (const InputError& error) {
    warn(std::string(error.what()) + "; using Slurm's defaults");
  }
  const std::vector<PlannedJob> jobs = jobs_of_work(submission, work, limits);
  std::set<TaskKind> kinds;
  for (const PlannedJob& job : jobs) kinds.insert(job.kind);
  for (const TaskKind kind : kinds) {
    std::printf("==> scripts/%s <==\n%s\n", script_name_of(kind).c_str(),
                script_of(kind, folder, submission).c_str());
  }
  std::printf("==> commands <==\n%s", sbatch_lines(folder, submission, jobs).c_str());
  return ExitCode::done;
}

void print_tasks(const Submission& submission, const Work& work)
{
  for (const PlannedJob& job : jobs_of_work(submission, work, no_limits)) {
    for (const TaskId& task : tasks_of(submission, job))
      std::printf("%s\n", full_text_of(task, submission).c_str());
  }
}

Json json_of(const Submission& submission, const SubmittedJob& submitted)
{
  const PlannedJob& job = submitted.job;
  const TaskId task{job.kind, job.case_number, 0};
  const Json name = job.case_number < 0 ? Json() : Json(case_of(submission, task).spec.name);
  return {{"id", submitted.id},
          {"kind", name_of(job.kind)},
          {"case", name},
          {"array", job.numbers.empty() ? Json() : Json(ranges_text(job.numbers))}};
}

}  // namespace

ExitCode start_tasks(const std::string& folder, const Submission& submission, const Work& work,
                     const StartOptions& options)
{
  if (options.is_dry && options.is_local) {
    print_tasks(submission, work);
    return ExitCode::done;
  }
  if (options.is_dry) return print_plan(folder, submission, work);
  if (options.is_local) return run_here(folder, submission, work, options);
  const std::vector<PlannedJob> jobs = jobs_of_work(submission, work, ask_limits());
  write_scripts(folder, submission, jobs);
  const std::vector<SubmittedJob> submitted = submit_jobs(folder, submission, jobs);
  if (!options.as_json) {
    for (const std::string& line : lines_of(submission, submitted)) std::printf("%s\n", line.c_str());
    return ExitCode::done;
  }
  Json list = Json::array();
  for (const SubmittedJob& job : submitted) list.push_back(json_of(submission, job));
  std::printf("%s\n", dumped({{"folder", folder}, {"jobs", list}}).c_str());
  return ExitCode::done;
}

}  // namespace vrda
