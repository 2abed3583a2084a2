#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/start_tasks.hpp"
#include "app/submit_command.hpp"
#include "cluster/local_run.hpp"
#include "cluster/missing.hpp"
#include "cluster/slurm.hpp"
#include "cluster/slurm_scripts.hpp"
#include "cluster/status.hpp"
#include "core/error.hpp"
#include "run/output_file.hpp"

namespace vrda {
namespace {

void replace_if_given(std::string& old, const std::string& given)
{
  if (!given.empty()) old = given;
}

SlurmOptions changed(SlurmOptions slurm, const SlurmOptions& given)
{
  replace_if_given(slurm.partition, given.partition);
  replace_if_given(slurm.time, given.time);
  replace_if_given(slurm.memory, given.memory);
  replace_if_given(slurm.account, given.account);
  replace_if_given(slurm.qos, given.qos);
  if (given.cpus > 0) slurm.cpus = given.cpus;
  if (given.max_parallel > 0) slurm.max_parallel = given.max_parallel;
  if (given.cases_per_task > 0) slurm.cases_per_task = given.cases_per_task;
  if (!given.extra.empty()) slurm.extra = given.extra;
  return slurm;
}

void say_reasons(const std::vector<std::string>& reasons)
{
  constexpr std::size_t most = 20;
  for (std::size_t k = 0; k < std::min(most, reasons.size()); ++k) say(reasons[k]);
  if (reasons.size() > most) say("and " + std::to_string(reasons.size() - most) + " more: vrda status");
}

void require_options(const ResumeOptions& options, const Submission& submission, const Missing& missing)
{
  if (options.is_local) {
    if (missing.n_under_way == 0) return;
    throw InputError({"--local", "", std::to_string(missing.n_under_way) + " tasks in Slurm's queue",
                      "vrda resume without --local, or scancel before"});
  }
  require_log_folder(absolute_folder(options.folder));
  require_sound(submission.slurm);
  if (submission.slurm.time.empty()) {
    throw InputError({"--time", "", "nothing", "a task's time limit, or --local as before"});
  }
}

// A node that could not begin a task may be mended by now, or another one begins it.
void release_held(const SubmissionSnapshot& seen)
{
  std::vector<std::string> held;
  for (const auto& [task, queue] : seen.slurm) {
    const bool is_new = std::find(held.begin(), held.end(), queue.job) == held.end();
    if (is_new && is_held_after_failed_launch(queue.row)) held.push_back(queue.job);
  }
  if (held.empty()) return;
  release_jobs(held);
  for (const std::string& job : held) say(job + " is released: Slurm held it since its launch failed");
}

ExitCode say_nothing_is_missing(const std::string& folder, const Missing& missing, bool as_json)
{
  if (as_json) {
    const nlohmann::ordered_json json = {{"folder", folder}, {"jobs", nlohmann::ordered_json::array()}};
    std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  }
  const std::string rest = missing.n_under_way == 0
                               ? "every result is there"
                               : std::to_string(missing.n_under_way) + " tasks are queued or running";
  say("nothing is missing: " + rest);
  return ExitCode::done;
}

}  // namespace

ExitCode resume_command(const ResumeOptions& options)
{
  const std::string folder = absolute_folder(options.folder);
  Submission submission = read_submission(folder);
  const OpenFile lock = locked_submission(folder);
  const SubmissionSnapshot seen = take_snapshot(folder, submission);
  if (!seen.remark.empty())
    throw InputError({folder, "", "tasks of which Slurm does not tell: " + seen.remark, "Slurm's answer"});
  if (!options.is_local && !options.is_dry) release_held(seen);
  const Missing missing = missing_of(folder, submission, status_of(folder, submission, seen), seen);
  if (missing.work.is_nothing()) return say_nothing_is_missing(folder, missing, options.as_json);
  const SlurmOptions slurm = changed(submission.slurm, options.slurm);
  const bool is_changed = !(slurm == submission.slurm);
  submission.slurm = slurm;
  require_options(options, submission, missing);
  if (options.slurm.cases_per_task > 0) require_same_span(seen.slurm, options.slurm.cases_per_task);
  say_reasons(missing.reasons);
  const StartOptions how{options.is_dry, options.is_local, options.n_workers, options.as_json};
  if (options.is_dry) return start_tasks(folder, submission, missing.work, how);
  for (const std::string& one : {scripts_of(folder), logs_of(folder), tasks_of(folder)}) make_folder(one);
  if (is_changed) write_submission(folder, submission);
  if (const auto fault = cancel_jobs(missing.to_cancel)) throw InputError(*fault);
  return start_tasks(folder, submission, missing.work, how);
}

}  // namespace vrda
