#include "cluster/hand_over.hpp"

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <set>

#include "cluster/slurm.hpp"
#include "cluster/slurm_scripts.hpp"
#include "cluster/task_state.hpp"
#include "core/error.hpp"
#include "core/whole_file.hpp"

namespace vrda {
namespace {

// Nobody would know of it.
void cancel_unnoted(const std::string& id)
{
  try {
    cancel_jobs({id});
  } catch (const InputError&) {
    // The first message is the one that matters, and names the job.
  }
}

}  // namespace

void write_scripts(const std::string& folder, const Submission& submission,
                   const std::vector<PlannedJob>& jobs)
{
  std::set<TaskKind> kinds;
  for (const PlannedJob& job : jobs) kinds.insert(job.kind);
  for (const TaskKind kind : kinds) {
    const std::string path = (std::filesystem::path(scripts_of(folder)) / script_name_of(kind)).string();
    write_whole(path, {script_of(kind, folder, submission)});
    constexpr mode_t readable_by_all = 0755;
    chmod(path.c_str(), readable_by_all);
  }
}

std::vector<SubmittedJob> hand_over(const std::string& folder, const Submission& submission,
                                    const std::vector<PlannedJob>& jobs)
{
  std::vector<SubmittedJob> submitted;
  std::vector<std::string> ids;
  try {
    for (const PlannedJob& job : jobs) {
      ids.push_back(submit_job(sbatch_words(folder, submission, job, ids), folder));
      const SubmittedJob one{ids.back(), utc_text(std::chrono::system_clock::now()), job};
      append_submitted(folder, one);
      submitted.push_back(one);
    }
  } catch (const InputError& error) {
    if (ids.size() > submitted.size()) cancel_unnoted(ids.back());
    if (submitted.empty()) throw;
    InputError::Facts facts = error.facts();
    facts.wanted += "; " + std::to_string(submitted.size()) + " of " + std::to_string(jobs.size()) +
                    " jobs were submitted before and go on, vrda resume " + folder + " submits the others";
    throw InputError(facts);
  }
  return submitted;
}

std::vector<std::string> lines_of(const Submission& submission, const std::vector<SubmittedJob>& jobs)
{
  std::vector<std::string> lines;
  std::int32_t shown = -2;
  for (const SubmittedJob& submitted : jobs) {
    const PlannedJob& job = submitted.job;
    const bool is_of_case = job.case_number >= 0;
    if (lines.empty() || (is_of_case && job.case_number != shown) || (!is_of_case && shown >= 0)) {
      const bool has_name = is_of_case && submission.has_index();
      lines.push_back(has_name ? submission.cases[static_cast<std::size_t>(job.case_number)].spec.name + ": "
                               : "");
    } else {
      lines.back() += ", ";
    }
    shown = job.case_number;
    std::string what = name_of(job.kind);
    if (job.kind == TaskKind::shard) what += "s";
    if (job.kind == TaskKind::run) what = submission.has_index() ? "cases" : "run";
    lines.back() += what + " " + id_text(submitted.id, job, submission.slurm);
  }
  return lines;
}

}  // namespace vrda
