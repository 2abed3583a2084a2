#include "run/jobs.hpp"

#include <algorithm>
#include <map>

#include "core/error.hpp"

namespace vrda::run {

store::Shard shard_of(const std::string& text)
{
  if (const auto shard = store::parse_shard(text, "/")) return *shard;
  throw InputError({"--shard", "", text.empty() ? "nothing" : text, "I/N with I from 1 to N, e.g. 3/8"});
}

std::vector<std::int32_t> rows_of(const store::Shard& shard, std::int32_t n_rows)
{
  check(shard.number >= 1 && shard.number <= shard.count,
        "a shard's number must be from 1 to the number of shards");
  std::vector<std::int32_t> rows;
  for (std::int32_t i = shard.number - 1; i < n_rows; i += shard.count) rows.push_back(i);
  return rows;
}

namespace {

// Appends the jobs of one case with shards; returns the last.
std::size_t append_jobs(std::vector<PlannedJob>& jobs, const CaseWork& work)
{
  PlannedJob job;
  job.case_number = work.case_number;
  std::vector<std::size_t> spine;
  if (work.needs_spine) {
    job.kind = TaskKind::spine;
    spine.push_back(jobs.size());
    jobs.push_back(job);
  }
  std::vector<std::size_t> before_merge = spine;
  if (!work.shards.empty()) {
    job.kind = TaskKind::shard;
    job.numbers = work.shards;
    job.after = spine;
    job.after_ids = work.active_spine_jobs;
    before_merge = {jobs.size()};
    jobs.push_back(job);
  }
  job.kind = TaskKind::merge;
  job.numbers.clear();
  job.after = before_merge;
  job.after_ids = work.active_shard_jobs;
  if (work.shards.empty()) {
    job.after_ids.insert(job.after_ids.end(), work.active_spine_jobs.begin(), work.active_spine_jobs.end());
  }
  jobs.push_back(job);
  return jobs.size() - 1;
}

// Arrays over the cases to run, as many as the maximum array size requires.
std::vector<std::size_t> append_runs(std::vector<PlannedJob>& jobs, const std::vector<std::int32_t>& cases,
                                     std::int32_t per_task, std::int32_t largest_number)
{
  std::map<std::int32_t, std::vector<std::int32_t>> numbers_by_chunk;
  for (const std::int32_t k : cases) {
    const std::int32_t task = k / per_task;
    std::vector<std::int32_t>& numbers = numbers_by_chunk[task / largest_number];
    const std::int32_t number = task % largest_number + 1;
    if (numbers.empty() || numbers.back() != number) numbers.push_back(number);
  }
  std::vector<std::size_t> appended;
  for (const auto& [chunk, numbers] : numbers_by_chunk) {
    PlannedJob job;
    job.kind = TaskKind::run;
    job.numbers = numbers;
    job.offset = chunk * largest_number * per_task;
    job.per_task = per_task;
    appended.push_back(jobs.size());
    jobs.push_back(job);
  }
  return appended;
}

// Checked in advance: otherwise sbatch would fail after some jobs were submitted.
void require_room(const Submission& submission, const std::vector<PlannedJob>& jobs, std::int32_t per_task,
                  const SlurmLimits& limits)
{
  const std::int64_t room = limits.max_job_count;
  std::int64_t n_jobs = 0;
  for (const PlannedJob& job : jobs) n_jobs += std::max<std::int64_t>(1, std::ssize(job.numbers));
  if (n_jobs <= room) return;
  const std::int64_t n_cases = std::ssize(submission.cases);
  const std::int64_t for_cases = std::max<std::int64_t>(1, room - (submission.has_index() ? 1 : 0));
  const std::string of_cases = " for " + std::to_string(n_cases) + (n_cases == 1 ? " case, " : " cases, ") +
                               std::to_string(n_jobs) + " jobs at once";
  const std::string wanted = "at most " + std::to_string(room) + ", Slurm's MaxJobCount, e.g. with ";
  if (submission.n_shards == 1) {
    const std::int64_t fitting = (n_cases + for_cases - 1) / for_cases;
    throw InputError({"--cases-per-task", "", std::to_string(per_task) + of_cases,
                      wanted + "--cases-per-task " + std::to_string(fitting)});
  }
  constexpr std::int64_t spine_and_merge = 2;
  const std::int64_t n_shards = std::max<std::int64_t>(1, for_cases / n_cases - spine_and_merge);
  const std::int64_t n_fitting = for_cases / (submission.n_shards + spine_and_merge);
  const bool has_alternative = n_cases > 1 && n_fitting > 0;
  throw InputError({"--shards", "", std::to_string(submission.n_shards) + of_cases,
                    wanted + "--shards " + std::to_string(n_shards) +
                        (has_alternative ? ", or " + std::to_string(n_fitting) + " cases at a time" : "")});
}

}  // namespace

Work all_work(const Submission& submission)
{
  CaseWork one;
  one.needs_run = submission.n_shards == 1;
  one.needs_spine = !one.needs_run;
  for (std::int32_t k = 1; k <= submission.n_shards && one.needs_spine; ++k) one.shards.push_back(k);
  Work work{std::vector<CaseWork>(submission.cases.size(), one), submission.has_index(), {}};
  for (std::int32_t k = 0; k < std::ssize(work.cases); ++k)
    work.cases[static_cast<std::size_t>(k)].case_number = k;
  return work;
}

std::int32_t cases_per_task(const Submission& submission, const SlurmLimits& limits)
{
  if (submission.slurm.cases_per_task > 0) return submission.slurm.cases_per_task;
  const std::int32_t room = std::max(1, limits.max_job_count / 2);
  const auto n_cases = static_cast<std::int32_t>(submission.cases.size());
  return (n_cases + room - 1) / room;
}

std::vector<PlannedJob> jobs_of_work(const Submission& submission, const Work& work,
                                     const SlurmLimits& limits)
{
  const std::int32_t largest_number = std::max(1, limits.max_array_size - 1);
  if (submission.n_shards > largest_number) {
    throw InputError({"--shards", "", std::to_string(submission.n_shards),
                      "at most " + std::to_string(largest_number) + ", Slurm's MaxArraySize minus one"});
  }
  std::vector<PlannedJob> jobs;
  std::vector<std::size_t> last;
  std::vector<std::int32_t> runs;
  for (const CaseWork& c : work.cases) {
    if (c.needs_run) {
      runs.push_back(c.case_number);
    } else {
      last.push_back(append_jobs(jobs, c));
    }
  }
  const std::int32_t per_task = cases_per_task(submission, limits);
  const std::vector<std::size_t> arrays = append_runs(jobs, runs, per_task, largest_number);
  last.insert(last.end(), arrays.begin(), arrays.end());
  if (work.needs_index) {
    PlannedJob index;
    index.kind = TaskKind::index;
    index.after = last;
    index.after_ids = work.active_case_jobs;
    jobs.push_back(index);
  }
  require_room(submission, jobs, per_task, limits);
  return jobs;
}

std::string ranges_text(const std::vector<std::int32_t>& numbers)
{
  std::string text;
  for (std::size_t k = 0; k < numbers.size();) {
    std::size_t end = k + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    text += (text.empty() ? "" : ",") + std::to_string(numbers[k]);
    if (end - k > 1) text += "-" + std::to_string(numbers[end - 1]);
    k = end;
  }
  return text;
}

std::string log_of_runs(std::int32_t offset, const std::string& number)
{
  return "run-" + std::to_string(offset) + "." + number + ".log";
}

std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job, std::int32_t number)
{
  if (job.kind == TaskKind::shard) return {{job.kind, job.case_number, number}};
  if (job.kind != TaskKind::run) return {{job.kind, job.case_number, 0}};
  std::vector<TaskId> tasks;
  const std::int32_t first = job.offset + (number - 1) * job.per_task;
  const std::int32_t end = std::min(first + job.per_task, static_cast<std::int32_t>(submission.cases.size()));
  for (std::int32_t k = std::max(0, first); k < end; ++k) tasks.push_back({TaskKind::run, k, 0});
  return tasks;
}

std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job)
{
  if (job.numbers.empty()) return tasks_of(submission, job, 0);
  std::vector<TaskId> tasks;
  for (const std::int32_t number : job.numbers) {
    const std::vector<TaskId> some = tasks_of(submission, job, number);
    tasks.insert(tasks.end(), some.begin(), some.end());
  }
  return tasks;
}

}  // namespace vrda::run
