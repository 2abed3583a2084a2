#include "run/submission.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "run/status.hpp"

namespace vrda::run {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* format = "vrda submission 1";

// Invariants of a submission, which a user may have edited.
bool is_valid(const Submission& s)
{
  return s.n_shards >= 1 && s.slurm.cpus >= 1 && !s.cases.empty() &&
         std::all_of(s.cases.begin(), s.cases.end(), [](const SubmittedCase& c) {
           return c.n_flexion >= 1 && c.n_varus >= 1 && c.n_samples >= 0;
         });
}

}  // namespace

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
  const auto submission = core::value_in<Submission>(file, path);
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

// Which tasks of a submission have no result yet, from journals and outputs (status.hpp).

namespace {

void add_once(std::vector<std::string>& ids, const std::string& id)
{
  if (!id.empty() && std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
}

const char* problem_of(const TaskView& view)
{
  if (view.status != TaskStatus::done) return name_of(view.status);
  switch (view.task.kind) {
    case TaskKind::spine:
    case TaskKind::shard:
      return "its journal is incomplete";
    case TaskKind::merge:
    case TaskKind::run:
      return "its model is missing, or its clean-up is incomplete";
    case TaskKind::index:
      break;
  }
  return "done, but older than its cases";
}

class Search {
 public:
  Search(const std::string& folder, const Submission& submission, const SubmissionSnapshot& snapshot)
      : submission_(submission), snapshot_(snapshot), counter_(folder, submission)
  {
  }

  MissingWork found(const StatusView& status)
  {
    for (const CaseView& view : status.cases) check_case(view);
    if (status.index) check_index(*status.index);
    return std::move(missing_);
  }

 private:
  void check_case(const CaseView& view)
  {
    const TaskView& last = view.tasks.back();
    note_end(last.task);
    if (view.is_complete) return;
    CaseWork work;
    work.case_number = view.case_number;
    const bool has_merge = last.task.kind == TaskKind::merge;
    for (const TaskView& task : view.tasks) {
      if (!view.is_merged && task.task.kind != TaskKind::merge) check_task(task, work);
    }
    if (!view.is_merged && has_merge && has_own_failure(last)) recheck_spine(view.tasks.front(), work);
    if (has_merge) return check_merge(last, work);
    if (work.needs_run) missing_.work.cases.push_back(work);
  }

  void check_task(const TaskView& view, CaseWork& work)
  {
    const TaskKind kind = view.task.kind;
    if (is_under_way(view)) {
      ++missing_.n_active;
      if (kind == TaskKind::spine) add_once(work.active_spine_jobs, view.slurm_job);
      if (kind == TaskKind::shard) add_once(work.active_shard_jobs, view.slurm_job);
      if (kind == TaskKind::run) add_once(missing_.work.active_case_jobs, view.slurm_job);
      return;
    }
    if (is_complete(view)) return;
    repeat(view, problem_of(view));
    if (kind == TaskKind::spine) work.needs_spine = true;
    if (kind == TaskKind::shard) work.shards.push_back(view.task.shard);
    if (kind == TaskKind::run) work.needs_run = true;
  }

  void check_merge(const TaskView& merge, const CaseWork& work)
  {
    const bool is_new = work.needs_spine || !work.shards.empty();
    const bool has_merge = is_under_way(merge);
    if (has_merge) ++missing_.n_active;
    if (has_merge && (!is_new || merge.status == TaskStatus::running)) {
      return add_once(missing_.work.active_case_jobs, merge.slurm_job);
    }
    // The queued merge would start without the new shards, or never.
    if (has_merge) add_once(missing_.to_cancel, merge.slurm_job);
    if (!has_merge) repeat(merge, problem_of(merge));
    missing_.work.cases.push_back(work);
  }

  void check_index(const TaskView& index)
  {
    const bool has_work = !missing_.work.cases.empty();
    const bool is_running = is_under_way(index) && index.status == TaskStatus::running;
    if (!has_work && is_under_way(index)) {
      ++missing_.n_active;
      return;
    }
    if (!has_work && index.status == TaskStatus::done && !is_outdated(index)) return;
    if (is_running) {
      // The running index may miss the new models, and must not overwrite the table of the next index task.
      ++missing_.n_active;
      add_once(missing_.work.active_case_jobs, index.slurm_job);
    }
    if (index.status == TaskStatus::queued) add_once(missing_.to_cancel, index.slurm_job);
    missing_.work.needs_index = true;
    if (!has_work) repeat(index, problem_of(index));
  }

  // In Slurm only: repeating a local task is safe because of its lock.
  bool is_under_way(const TaskView& view) const
  {
    const bool is_local = snapshot_.locked.count(view.task) > 0;
    return !is_local &&
           (view.status == TaskStatus::queued || view.status == TaskStatus::running || view.is_job_running);
  }

  const TaskState* state_of(const TaskId& task) const
  {
    const auto state = snapshot_.states.find(task);
    return state == snapshot_.states.end() ? nullptr : &state->second;
  }

  // The merge itself failed, not one of its dependencies.
  bool has_own_failure(const TaskView& merge) const
  {
    const TaskState* own = state_of(merge.task);
    return merge.status == TaskStatus::failed && own != nullptr && own->status == TaskStatus::failed &&
           own->slurm_job == merge.slurm_job;
  }

  // UTC texts sort like times. An end in the future is due to a changed clock and is ignored.
  void note_end(const TaskId& last)
  {
    const TaskState* own = state_of(last);
    if (own == nullptr || own->status != TaskStatus::done) return;
    if (own->ended <= now_) last_end_ = std::max(last_end_, own->ended);
  }

  // E.g. when the next index task was never submitted, or killed.
  bool is_outdated(const TaskView& index) const
  {
    const TaskState* own = state_of(index.task);
    return !missing_.work.active_case_jobs.empty() || (own != nullptr && last_end_ > own->started);
  }

  // With free varus the total is unknown: whether the spine is complete is determined only by a merge, a
  // shard or the spine task, which must load the meshes.
  void recheck_spine(const TaskView& spine, CaseWork& work)
  {
    const bool is_all_done = !is_under_way(spine) && !work.needs_spine && work.shards.empty();
    if (!is_all_done || counter_.count(spine.task).n_total > 0) return;
    work.needs_spine = true;
    repeat(spine, "its journal may be incomplete, since the merge failed");
  }

  bool is_complete(const TaskView& view)
  {
    if (view.status != TaskStatus::done || view.task.kind == TaskKind::run) return false;
    const SolvedCount solved = counter_.count(view.task);
    if (solved.n_total > 0) return solved.n_done == solved.n_total;
    return view.task.kind == TaskKind::shard || solved.n_done > 0;
  }

  void repeat(const TaskView& view, const char* what)
  {
    const std::string line = full_text_of(view.task, submission_) + ": " + what;
    missing_.reasons.push_back(view.reason.empty() ? line : line + ": " + view.reason);
    // A job with a dependency that can never be satisfied.
    const auto job = snapshot_.slurm.find(view.task);
    if (job != snapshot_.slurm.end() && job->second.row.state == "PENDING")
      add_once(missing_.to_cancel, job->second.job);
  }

  const Submission& submission_;
  const SubmissionSnapshot& snapshot_;
  const std::string now_ = utc_now();
  SolvedCounter counter_;
  std::string last_end_;  // UTC, of the completed cases
  MissingWork missing_;
};

}  // namespace

MissingWork find_missing_work(const std::string& folder, const Submission& submission,
                              const StatusView& status, const SubmissionSnapshot& snapshot)
{
  return Search(folder, submission, snapshot).found(status);
}

namespace {

// Stops at the first missing step.
solve::SweepResult replay(solve::SweepPlan plan, const std::map<StepKey, StepRecord>& steps)
{
  const solve::SolveStep nothing = [](const solve::StepTask&) -> StepRecord {
    throw InternalError("a replay solves no step");
  };
  solve::SweepHooks hooks;
  hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
    const auto found = steps.find(key);
    return found == steps.end() ? std::nullopt : std::optional(found->second);
  };
  hooks.is_stopped = [] { return true; };
  return solve::sweep(plan, nothing, hooks, 1);
}

bool is_complete(solve::SweepPlan plan, const std::map<StepKey, StepRecord>& steps,
                 std::vector<std::int32_t> rows)
{
  plan.rows = std::move(rows);
  return replay(std::move(plan), steps).is_complete;
}

std::vector<std::int32_t> rows_of_plan(const solve::SweepPlan& plan)
{
  if (plan.rows) return *plan.rows;
  std::vector<std::int32_t> all;
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) all.push_back(static_cast<std::int32_t>(i));
  return all;
}

// Adds an incomplete row.
void add_row(MissingSteps& missing, const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps,
             std::int32_t row)
{
  IncompleteRow part{row, {}};
  bool has_results = false;
  for (std::int32_t j = 0; j < static_cast<std::int32_t>(plan.varus_rad.size()); ++j) {
    const bool is_solved = steps.count({StepKind::row, row, j}) > 0;
    has_results = has_results || is_solved;
    if (!is_solved && steps.count({StepKind::spine, row, j}) == 0) part.columns.push_back(j);
  }
  missing.rows.push_back(row);
  missing.n_attitudes += static_cast<std::int32_t>(part.columns.size());
  if (has_results && !part.columns.empty()) missing.incomplete_rows.push_back(std::move(part));
}

void take(CollectedSteps& collected, std::map<StepKey, std::string>& came_from, const StepRecord& record,
          const std::string& journal)
{
  const auto [there, is_new] = collected.steps.emplace(record.key, record);
  if (is_new) {
    came_from.emplace(record.key, journal);
    return;
  }
  if (core::bytes_of_value(there->second) == core::bytes_of_value(record)) {
    ++collected.n_duplicates;
    collected.duplicate_rows.insert(record.key.flexion);
    collected.duplicate_journals.insert({came_from.at(record.key), journal});
    return;
  }
  throw InputError({journal,
                    std::string(name_of(record.key.kind)) + " step at flexion " +
                        std::to_string(record.key.flexion) + ", varus " + std::to_string(record.key.varus) +
                        " of the grid",
                    "a result that differs from that in " + came_from.at(record.key),
                    "the same result, since the job is the same; leave out the wrong journal"});
}

}  // namespace

CollectedSteps collect_steps(const std::vector<std::string>& journals, const std::string& key)
{
  CollectedSteps collected;
  std::map<StepKey, std::string> came_from;
  for (const std::string& journal : journals) {
    const store::JournalContent content = store::read_journal(journal);
    if (content.key != key) {
      throw InputError({journal, "key", "the journal of another job (" + content.key + ")",
                        key + "; leave it out, or pass its own job"});
    }
    if (!content.dropped_reason.empty()) {
      collected.warnings.push_back(journal + ": dropped " + std::to_string(content.dropped_bytes) +
                                   " bytes at the end (" + content.dropped_reason + ")");
    }
    for (const StepRecord& record : content.records) take(collected, came_from, record, journal);
  }
  return collected;
}

MissingSteps missing_steps(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps)
{
  MissingSteps missing;
  const std::vector<std::int32_t> rows = rows_of_plan(plan);
  if (is_complete(plan, steps, rows)) {  // one replay instead of one per row
    missing.is_spine_complete = true;
    return missing;
  }
  missing.is_spine_complete = is_complete(plan, steps, {});
  for (const std::int32_t row : rows) {
    if (missing.is_spine_complete && is_complete(plan, steps, {row})) continue;
    add_row(missing, plan, steps, row);
  }
  return missing;
}

solve::SweepResult replay_sweep(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps)
{
  solve::SweepResult result = replay(plan, steps);
  check(result.is_complete, "a replay needs every step");
  return result;
}

std::string angles_text(const std::vector<std::int32_t>& indices, const std::vector<double>& angles_deg)
{
  const auto degrees = [&](std::size_t k) {
    return shortest_decimal(angles_deg[static_cast<std::size_t>(indices[k])]);
  };
  std::vector<std::string> parts;
  for (std::size_t first = 0, last = 0; first < indices.size(); first = last + 1) {
    last = first;
    while (last + 1 < indices.size() && indices[last + 1] == indices[last] + 1) ++last;
    if (last >= first + 2) {
      parts.push_back(degrees(first) + " to " + degrees(last));
    } else {
      for (std::size_t k = first; k <= last; ++k) parts.push_back(degrees(k));
    }
  }
  return join_alternatives(parts, " and ");
}

std::string missing_text(const MissingSteps& missing, const std::vector<double>& flexion_deg,
                         const std::vector<double>& varus_deg)
{
  if (missing.rows.empty()) return {};
  if (missing.n_attitudes == 0 && missing.is_spine_complete) {
    return "no rotation band at flexion " + angles_text(missing.rows, flexion_deg);
  }
  if (missing.n_attitudes == 0) return {};
  std::vector<std::int32_t> whole;
  std::size_t next = 0;
  for (const std::int32_t row : missing.rows) {
    if (next < missing.incomplete_rows.size() && missing.incomplete_rows[next].row == row) {
      ++next;
    } else {
      whole.push_back(row);
    }
  }
  std::string text = "no result for " + std::to_string(missing.n_attitudes) + " of " +
                     std::to_string(flexion_deg.size() * varus_deg.size()) + " attitudes";
  if (!whole.empty()) text += ", at flexion " + angles_text(whole, flexion_deg);
  for (const IncompleteRow& part : missing.incomplete_rows) {
    text += std::string(text.ends_with("attitudes") ? "," : ", and") + " at flexion " +
            angles_text({part.row}, flexion_deg) + " of varus " + angles_text(part.columns, varus_deg);
  }
  return text;
}

}  // namespace vrda::run
