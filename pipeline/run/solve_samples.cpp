#include "run/solve_samples.hpp"

#include <atomic>
#include <numeric>

#include "core/console.hpp"
#include "core/parallel.hpp"
#include "run/summary.hpp"
#include "solve/case_solver.hpp"
#include "solve/sample_motion.hpp"
#include "job/sampled_case.hpp"

namespace vrda::run {
namespace {

// All flexions of a sample, or nothing.
std::vector<StepRecord> records_of(std::int32_t sample, std::size_t n_flexion,
                                   const std::map<StepKey, StepRecord>& steps)
{
  std::vector<StepRecord> records;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(n_flexion); ++i) {
    const auto found = steps.find({StepKind::sample, i, sample});
    if (found == steps.end()) return {};
    records.push_back(found->second);
  }
  return records;
}

class SampleRun {
 public:
  SampleRun(const job::Case& job_case, const solve::SweepPlan& plan, const solve::SweepResult& job,
            const std::vector<std::int32_t>& samples, StepLog& log)
      : plan_(plan), job_(job), samples_(samples), log_(log), inputs_(job_case), records_(samples.size())
  {
    if (inputs_.has_same_geometry()) {
      joint_ = std::make_shared<const solve::Joint>(
          solve::joint_of(job_case, solve::frame_of(job_case, job_case.push.front())));
    }
  }

  std::optional<std::vector<StepRecord>> run(int n_threads, const RunOptions& options)
  {
    std::vector<std::size_t> to_solve;
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      records_[k] = records_of(samples_[k], job_.free_spine.size(), log_.known);
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
    solve::CaseSolver solver(sampled, 1, joint_);
    const solve::SolveStep solve = [&](const solve::StepTask& task) { return solver(task); };
    return solve::sample_motion(plan_, job_, solve, {sample, core::is_interrupted});
  }

  const solve::SweepPlan& plan_;
  const solve::SweepResult& job_;
  const std::vector<std::int32_t>& samples_;
  StepLog& log_;
  const job::SampledCase inputs_;
  std::shared_ptr<const solve::Joint> joint_;  // null: each sample has its own
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
                                                     const solve::SweepResult& job,
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
    std::vector<StepRecord> records = records_of(sample, job_case.grid.flexion_deg.size(), steps);
    if (records.empty()) known.missing.push_back(sample);
    for (StepRecord& record : records) known.records.push_back(std::move(record));
  }
  return known;
}

}  // namespace vrda::run
