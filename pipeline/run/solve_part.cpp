#include "run/solve_part.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <numeric>
#include <thread>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "job/sampled_case.hpp"
#include "run/campaign.hpp"
#include "run/submission.hpp"
#include "solve/case_solver.hpp"
#include "solve/compliant_contact.hpp"
#include "solve/followers.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {
namespace {

// Two chains and the restarts; starts propagated from neighbours are not known in advance.
int n_known_starts(const solve::SweepPlan& plan)
{
  return 2 + plan.n_restarts;
}

bool is_counted(const StepKey& key, const solve::SweepPlan& plan, ProgressUnit counted)
{
  const bool is_spine = key.kind == StepKind::spine;
  if (counted == ProgressUnit::cells) return is_spine || key.kind == StepKind::row;
  if (plan.spine != solve::SpineRule::free_varus) return is_spine;
  return key.kind == StepKind::free_spine && key.varus < n_known_starts(plan);
}

int n_counted(const solve::SweepPlan& plan, ProgressUnit counted)
{
  const std::size_t n_flexion = plan.flexion_rad.size();
  const std::size_t n_rows = plan.rows ? plan.rows->size() : n_flexion;
  if (counted == ProgressUnit::cells) return static_cast<int>(n_rows * plan.varus_rad.size());
  if (plan.spine != solve::SpineRule::free_varus) return static_cast<int>(n_flexion);
  return static_cast<int>(path_of(plan).size()) * n_known_starts(plan);
}

bool is_of_plan(const StepKey& key, const solve::SweepPlan& plan)
{
  return !plan.rows || std::find(plan.rows->begin(), plan.rows->end(), key.flexion) != plan.rows->end();
}

int n_counted_of(const std::map<StepKey, StepRecord>& steps, const solve::SweepPlan& plan,
                 ProgressUnit counted)
{
  return static_cast<int>(std::count_if(steps.begin(), steps.end(), [&](const auto& step) {
    const bool is_here = counted == ProgressUnit::spine || is_of_plan(step.first, plan);
    return is_here && is_counted(step.first, plan, counted);
  }));
}

}  // namespace

SolvedPart solve_part(const job::Case& job_case, const solve::SweepPlan& plan, ProgressUnit counted,
                      const RunOptions& options, StepLog& log, const std::map<StepKey, StepRecord>& spine)
{
  const int n_threads = thread_count_or_all(options.n_threads);
  solve::CaseSolver solver(job_case, n_threads);
  const int n_total = n_counted(plan, counted);
  const int n_known = n_counted_of(log.known, plan, counted) + n_counted_of(spine, plan, counted);
  if (options.on_solving_start) options.on_solving_start();
  const char* what = counted == ProgressUnit::cells ? "attitudes" : "steps of the spine";
  core::Progress progress(core::progress_style_of(options.progress), what, n_total, n_known);

  std::atomic<int> n_done = n_known;
  if (options.on_progress) options.on_progress(n_known, n_total);

  const solve::SolveStep solve = [&](const solve::StepTask& task) {
    if (!log.traces || !task.is_measured || task.followers != nullptr) return solver(task);
    return solve_with_trace(*log.traces, task.key, task.seed,
                            [&](const SearchObserver& watch) { return solver(task, watch); });
  };
  solve::SweepHooks hooks;
  hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
    const auto found = spine.find(key);
    return found == spine.end() ? recalled_step(log, key) : std::optional(found->second);
  };
  hooks.keep = [&](const StepRecord& record) {
    log.writer.append(record);
    if (!is_counted(record.key, plan, counted)) return;
    progress.advance();
    if (options.on_progress) options.on_progress(++n_done, n_total);
  };
  hooks.is_stopped = core::is_interrupted;
  solve::SweepResult result = solve::sweep(plan, solve, hooks, n_threads);
  if (log.traces) log.traces->flush();
  log.writer.flush();
  return {std::move(result), solver.joint()};
}

core::ExitCode report_interrupted(const StepLog& log)
{
  core::log_info("interrupted: solved steps are in " + log.path + "; run the same command to resume");
  return core::ExitCode::interrupted;
}

namespace {

// A restarted task may find its predecessor still ending.
constexpr std::chrono::seconds own_journal_timeout{60};
// The task that solves the spine holds its lock until it is complete.
constexpr std::chrono::hours spine_journal_timeout{24 * 365};

using Steps = std::map<StepKey, StepRecord>;

struct ShardedRun {
  job::Case job_case;
  std::string output;
  std::string key;
};

ShardedRun prepared(const RunOptions& options)
{
  if (options.writes_trace) {
    throw InputError({"--trace", "", "a part of a run", "a complete run, without --spine and --shard"});
  }
  ShardedRun run{load_and_report_case(options.job_file, options),
                 output_path_of(options.output, options.job_file), ""};
  make_parent_folder(run.output);
  existing_result(run.job_case, run.output, options.may_replace);  // throws for that of another job
  run.key = solve::fingerprint_of(run.job_case);
  core::install_signal_handlers();
  return run;
}

solve::SweepPlan plan_of_rows(const job::Case& job_case, std::vector<std::int32_t> rows)
{
  solve::SweepPlan plan = solve::plan_of(job_case);
  plan.rows = std::move(rows);
  return plan;
}

// The steps in a journal; empty without a file.
Steps steps_in(const std::string& path, const std::string& key)
{
  return access(path.c_str(), F_OK) == 0 ? collect_steps({path}, key).steps : Steps{};
}

bool has_whole_spine(const ShardedRun& run, const Steps& steps)
{
  return missing_steps(plan_of_rows(run.job_case, {}), steps).is_spine_complete;
}

// Called under the lock of the spine's journal, so that only one task writes the shared files.
void write_shared_files(const ShardedRun& run, const RunOptions& options)
{
  run::write_case_file(run::case_file_of(run.output),
                       {run::case_of_job(options.job_file, options.data_directory, options.overrides), ""});
  if (has_start_file(run.output, run.job_case.resolved_job)) return;
  store::write_motion_model(store::start_file_of(run.output), solve::pending_model_of(run.job_case));
}

// Empty when interrupted.
std::optional<Steps> solved_spine(const ShardedRun& run, const RunOptions& options, bool is_fresh)
{
  const std::string path = store::spine_journal_of(run.output);
  JournalWait patience = options.journal_wait.value_or(JournalWait{});
  patience.timeout = spine_journal_timeout;
  std::optional<StepLog> log = open_log_waiting(path, run.key, is_fresh, patience);
  if (!log) return std::nullopt;
  const bool is_complete = with_journal_restore(*log, run.output, [&] {
    write_shared_files(run, options);
    const solve::SweepPlan plan = plan_of_rows(run.job_case, {});
    return solve_part(run.job_case, plan, ProgressUnit::spine, options, *log).result.is_complete;
  });
  if (is_complete) return steps_in(path, run.key);
  report_interrupted(*log);
  return std::nullopt;
}

core::ExitCode solve_rows(const ShardedRun& run, const RunOptions& options, const Steps& spine)
{
  const std::string path = store::shard_journal_of(run.output, *options.shard);
  std::optional<StepLog> log = open_log_waiting(
      path, run.key, options.is_fresh, options.journal_wait.value_or(JournalWait{own_journal_timeout}));
  if (!log && core::is_interrupted()) return core::ExitCode::interrupted;
  if (!log) {
    throw InputError({path, "", "a journal that another run is writing", "no other run of the same shard"});
  }
  const auto n_rows = static_cast<std::int32_t>(run.job_case.grid.flexion_deg.size());
  const solve::SweepPlan plan = plan_of_rows(run.job_case, run::rows_of(*options.shard, n_rows));
  const bool is_complete = with_journal_restore(*log, run.output, [&] {
    const SolvedPart part = solve_part(run.job_case, plan, ProgressUnit::cells, options, *log, spine);
    return part.result.is_complete &&
           solve_samples(run.job_case, plan, part, run::rows_of(*options.shard, n_samples_of(run.job_case)),
                         options, *log)
               .has_value();
  });
  if (!is_complete) return report_interrupted(*log);
  std::printf("%s\n", path.c_str());
  return core::ExitCode::done;
}

}  // namespace

core::ExitCode spine_command(const RunOptions& options)
{
  const ShardedRun run = prepared(options);
  const auto spine =
      with_difference_in_errors(run.job_case, [&] { return solved_spine(run, options, options.is_fresh); });
  if (!spine) return core::ExitCode::interrupted;
  std::printf("%s\n", store::spine_journal_of(run.output).c_str());
  return core::ExitCode::done;
}

core::ExitCode shard_command(const RunOptions& options)
{
  const ShardedRun run = prepared(options);
  return with_difference_in_errors(run.job_case, [&] {
    std::optional<Steps> spine = steps_in(store::spine_journal_of(run.output), run.key);
    if (!has_whole_spine(run, *spine)) spine = solved_spine(run, options, false);
    return spine ? solve_rows(run, options, *spine) : core::ExitCode::interrupted;
  });
}

namespace {

// All flexions of a sample and of its followers, or nothing.
std::vector<StepRecord> records_of(std::int32_t sample, const job::Case& job_case,
                                   const std::map<StepKey, StepRecord>& steps)
{
  std::vector<StepRecord> records;
  const auto add = [&](const StepKey& key) {
    const auto found = steps.find(key);
    if (found != steps.end()) records.push_back(found->second);
    return found != steps.end();
  };
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(job_case.grid.flexion_deg.size()); ++i) {
    bool is_there = add({StepKind::sample, i, sample});
    for (std::int32_t k = 0; is_there && k < static_cast<std::int32_t>(job_case.followers.size()); ++k)
      is_there = add(solve::sample_follower_key(i, sample, k));
    if (!is_there) return {};
  }
  return records;
}

class SampleRun {
 public:
  SampleRun(const job::Case& job_case, const solve::SweepPlan& plan, const SolvedPart& job,
            const std::vector<std::int32_t>& samples, StepLog& log)
      : case_(job_case),
        plan_(plan),
        job_(job.result),
        samples_(samples),
        log_(log),
        inputs_(job_case),
        records_(samples.size())
  {
    const bool is_compliant = job_case.equilibrium.contact_stiffness_n_per_mm3 > 0.0;
    if (inputs_.has_same_geometry() || (is_compliant && inputs_.thickness_change_mm(0))) joint_ = job.joint;
    if (joint_ && is_compliant) joint_->compliant->of(*joint_);
  }

  std::optional<std::vector<StepRecord>> run(int n_threads, const RunOptions& options)
  {
    std::vector<std::size_t> to_solve;
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      records_[k] = records_of(samples_[k], case_, log_.known);
      if (records_[k].empty()) to_solve.push_back(k);
    }
    const auto n_total = static_cast<int>(samples_.size());
    std::atomic<int> n_done = n_total - static_cast<int>(to_solve.size());
    core::Progress progress(core::progress_style_of(options.progress), "samples", n_total, n_done);
    if (options.on_progress) options.on_progress(n_done, n_total);
    try {
      for_each_index(to_solve.size(), n_threads, [&] {
        return [&](std::size_t k) {
          if (core::is_interrupted() || !solve(to_solve[k])) return;
          progress.advance();
          if (options.on_progress) options.on_progress(++n_done, n_total);
        };
      });
    } catch (...) {
      log_.writer.flush();
      throw;
    }
    log_.writer.flush();
    std::vector<StepRecord> all;
    for (const std::vector<StepRecord>& of_sample : records_) {
      if (of_sample.empty()) return std::nullopt;
      all.insert(all.end(), of_sample.begin(), of_sample.end());
    }
    return all;
  }

 private:
  // Whether the sample was solved before an interruption.
  bool solve(std::size_t row)
  {
    std::vector<StepRecord> solved = solved_sample(samples_[row]);
    for (const StepRecord& record : solved) {
      if (log_.known.count(record.key) == 0) log_.writer.append(record);
    }
    records_[row] = std::move(solved);
    return !records_[row].empty();
  }

  std::vector<StepRecord> solved_sample(std::int32_t sample) const
  {
    const job::Case sampled = inputs_.at(sample);
    solve::CaseSolver solver(sampled, 1, joint_at(sample, sampled));
    const solve::SolveStep solve = [&](const solve::StepTask& task) { return solver(task); };
    solve::SampleOptions options{sample, sampled.prior, core::is_interrupted};
    if (!sampled.followers.empty())
      options.follow = [&](const solve::SweepPlan& plan, const solve::SolveStep& step,
                           const solve::SweepHooks& hooks, int n_threads, solve::SweepResult& result) {
        return solve::follow(sampled, plan, step, hooks, n_threads, result);
      };
    return solve::sample_motion(plan_, job_, solve, options);
  }

  // The job's own; with other thicknesses, one with the distances of the job's, which are most of the work,
  // and its moving object where that is the same.
  std::shared_ptr<const solve::Joint> joint_at(std::int32_t sample, const job::Case& sampled) const
  {
    if (!joint_ || inputs_.has_same_geometry()) return joint_;
    solve::Joint joint = solve::joint_like(*joint_, sampled, solve::frame_of(sampled, sampled.push.front()));
    joint.compliant = joint_->compliant;
    joint.thicker_than_compliant_mm = *inputs_.thickness_change_mm(sample);
    return std::make_shared<const solve::Joint>(std::move(joint));
  }

  const job::Case& case_;
  const solve::SweepPlan& plan_;
  const solve::SweepResult& job_;
  const std::vector<std::int32_t>& samples_;
  StepLog& log_;
  const job::SampledCase inputs_;
  std::shared_ptr<const solve::Joint> joint_;  // of the job; null: each sample has its own
  std::vector<std::vector<StepRecord>> records_;
};

}  // namespace

std::int32_t n_samples_of(const job::Case& job_case)
{
  return job_case.uncertainty ? job_case.uncertainty->n_samples : 0;
}

std::vector<std::int32_t> all_samples(const job::Case& job_case)
{
  std::vector<std::int32_t> samples(static_cast<std::size_t>(n_samples_of(job_case)));
  std::iota(samples.begin(), samples.end(), 0);
  return samples;
}

std::optional<std::vector<StepRecord>> solve_samples(const job::Case& job_case, const solve::SweepPlan& plan,
                                                     const SolvedPart& job,
                                                     const std::vector<std::int32_t>& samples,
                                                     const RunOptions& options, StepLog& log)
{
  if (samples.empty()) return std::vector<StepRecord>{};
  return SampleRun(job_case, plan, job, samples, log).run(thread_count_or_all(options.n_threads), options);
}

KnownSamples known_samples(const job::Case& job_case, const std::map<StepKey, StepRecord>& steps)
{
  KnownSamples known;
  for (const std::int32_t sample : all_samples(job_case)) {
    std::vector<StepRecord> records = records_of(sample, job_case, steps);
    if (records.empty()) known.missing.push_back(sample);
    for (StepRecord& record : records) known.records.push_back(std::move(record));
  }
  return known;
}

}  // namespace vrda::run
