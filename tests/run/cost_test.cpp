#include "run/campaign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <mutex>

#include "core/units.hpp"

namespace vrda::cost_test {

solve::SweepPlan plan_of(solve::SpineRule rule, int n_flexion, int n_varus)
{
  solve::SweepPlan plan;
  plan.spine = rule;
  for (int i = 0; i < n_flexion; ++i) plan.flexion_rad.push_back(rad_from_deg(5.0 * i));
  for (int j = 0; j < n_varus; ++j) plan.varus_rad.push_back(rad_from_deg(2.0 * (j - n_varus / 2)));
  return plan;
}

struct Solved {
  std::map<StepKind, std::int64_t> by_kind;
  std::int64_t n_kept = 0;
};

// Sweeps with a counting solver: every step stable, both compartments in contact, highest at zero varus.
Solved solved_by(const solve::SweepPlan& plan)
{
  Solved solved;
  std::mutex mutex;
  const solve::SolveStep solve = [&](const solve::StepTask& task) {
    const std::lock_guard lock(mutex);
    ++solved.by_kind[task.key.kind];
    StepRecord record;
    record.status = StepStatus::stable;
    record.contact_medial = record.contact_lateral = true;
    record.varus_rad = task.is_varus_free ? 0.0 : task.attitude.varus_rad;
    record.pose.translation_mm = {0.0, -std::abs(task.attitude.varus_rad), 0.0};
    return record;
  };
  solve::SweepHooks hooks;
  hooks.keep = [&](const StepRecord&) {
    const std::lock_guard lock(mutex);
    ++solved.n_kept;
  };
  EXPECT_TRUE(solve::sweep(plan, solve, hooks, 2).is_complete);
  return solved;
}

void expect_counted(const solve::SweepPlan& plan)
{
  Solved solved = solved_by(plan);
  const run::StepCounts counts = run::step_counts(plan);
  std::map<StepKind, std::int64_t>& n = solved.by_kind;
  EXPECT_EQ(counts.spine(), n[StepKind::spine_probe] + n[StepKind::free_spine]);
  EXPECT_EQ(counts.bands, n[StepKind::band]);
  EXPECT_EQ(counts.cells, n[StepKind::row] + n[StepKind::spine]);
  EXPECT_EQ(counts.records, solved.n_kept);
}

TEST(StepCounts, AreWhatASweepSolvesByEverySpineRule)
{
  for (const solve::SpineRule rule :
       {solve::SpineRule::nearest_zero, solve::SpineRule::walk_to_balance, solve::SpineRule::free_varus}) {
    for (const int n_flexion : {1, 2, 7}) {
      for (const int n_varus : {1, 2, 3, 6}) {
        for (const bool has_band : {false, true}) {
          SCOPED_TRACE(testing::Message()
                       << static_cast<int>(rule) << ' ' << n_flexion << ' ' << n_varus << ' ' << has_band);
          solve::SweepPlan plan = plan_of(rule, n_flexion, n_varus);
          plan.has_band = has_band;
          plan.n_restarts = has_band ? 4 : 0;
          expect_counted(plan);
          plan.rows = std::vector<std::int32_t>{0};
          expect_counted(plan);
          plan.rows = std::vector<std::int32_t>{};
          expect_counted(plan);
        }
      }
    }
  }
}

TEST(StepCounts, OfVarusLeftFreeOnlyTheBandsAreInTheRows)
{
  solve::SweepPlan plan = plan_of(solve::SpineRule::free_varus, 91, 1);
  plan.is_varus_free = plan.has_band = true;
  plan.n_restarts = 4;
  expect_counted(plan);
  const run::StepCounts counts = run::step_counts(plan);
  EXPECT_EQ(counts.chain, 2 * 91 + 2 * 90);
  EXPECT_EQ(counts.restarts, 91 * (4 + 12));
  EXPECT_EQ(counts.bands, 182);
  EXPECT_EQ(counts.cells, 0);
}

run::CaseSize size_of_knee()
{
  return {false, 4746, 10602, 21, 91, 21, 1};
}

// Whole runs measured with one thread on the machine of results/benchmarks.md: processor seconds of the spine
// and of the rows together, resident memory, bytes of all journals and of the model.
TEST(Cost, RunsMeasuredLieWithinTheSpread)
{
  struct Run {
    const char* name;
    run::CaseSize size;
    run::StepCounts steps;
    double solving_s, memory_mb, journal_kb, model_kb;
  };
  const Run runs[] = {
      {"generic knee, 91 x 21", size_of_knee(), {182, 364, 182, 1911, 2639}, 1.98, 41, 1413, 2859},
      {"generic knee, four times finer",
       {false, 74636, 128428, 21, 31, 9, 1},
       {62, 124, 62, 279, 527},
       2.28,
       111,
       767,
       3676},
      {"generic knee by search", {true, 4746, 10602, 0, 31, 9, 1}, {93, 0, 0, 248, 372}, 6.57, 31, 299, 648},
      {"a real knee by its 55 fibres, varus free",
       {false, 75274, 81596, 55, 91, 1, 1},
       {182, 364, 182, 0, 819},
       2.46,
       99,
       573,
       2109},
      {"a real knee by contact",
       {false, 81596, 81596, 0, 31, 9, 1},
       {62, 124, 0, 279, 465},
       1.78,
       120,
       328,
       2141},
      {"a real knee by search", {true, 97182, 97182, 0, 10, 9, 1}, {30, 0, 0, 80, 120}, 10.5, 133, 89, 2644},
  };
  for (const Run& run : runs) {
    SCOPED_TRACE(run.name);
    const run::CaseCost cost = run::cost_of(run.size, run.steps);
    const auto expect_near = [](double estimate, double measured) {
      EXPECT_LT(estimate, run::cost_spread * measured);
      EXPECT_GT(estimate, measured / run::cost_spread);
    };
    expect_near(cost.solving_s(), run.solving_s);
    expect_near(cost.memory_bytes, 1e6 * run.memory_mb);
    expect_near(cost.journal_bytes, 1e3 * run.journal_kb);
    expect_near(cost.model_bytes, 1e3 * run.model_kb);
  }
}

}  // namespace vrda::cost_test
