#include "solve/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <mutex>

#include "core/units.hpp"

namespace vrda::free_spine_test {

StepRecord end_at(double theta_deg, double energy_nmm, StepStatus status = StepStatus::stable)
{
  StepRecord record;
  record.status = status;
  record.pose.theta_rad = rad_from_deg(theta_deg);
  record.balance.energy_nmm = energy_nmm;
  return record;
}

TEST(FreeSpine, TheLowestEnergyIsChosenAndOtherEquilibriaAreCounted)
{
  const solve::FreeSpineStep step =
      solve::select_lowest({end_at(3.0, -5.0), end_at(3.05, -5.0), end_at(-4.0, -7.5),
                            end_at(9.0, -99.0, StepStatus::unbounded), end_at(6.0, -5.5)});
  EXPECT_EQ(step.chosen.pose.theta_rad, rad_from_deg(-4.0));
  EXPECT_EQ(step.n_optima, 3);
  EXPECT_DOUBLE_EQ(step.theta_spread_rad, rad_from_deg(6.0) - rad_from_deg(-4.0));
  EXPECT_DOUBLE_EQ(step.energy_spread_nmm, 2.5);
}

TEST(FreeSpine, OfEachEquilibriumTheLowestResultIsKept)
{
  // 3 and 3.05 degrees are one equilibrium, of which the second is lower; so are -4 and -4.05.
  const solve::FreeSpineStep step =
      solve::select_lowest({end_at(3.0, -5.0), end_at(-4.0, -7.5), end_at(3.05, -5.2),
                            end_at(9.0, -99.0, StepStatus::unbounded), end_at(-4.05, -7.5 - 1e-7)});
  ASSERT_EQ(step.equilibria.size(), 2u);
  EXPECT_EQ(step.equilibria[0].pose.theta_rad, rad_from_deg(3.05));
  EXPECT_EQ(step.equilibria[0].energy_nmm, -5.2);
  EXPECT_FALSE(step.equilibria[0].is_chosen);
  EXPECT_EQ(step.equilibria[1].pose.theta_rad, rad_from_deg(-4.0)) << "of equal energies the earlier";
  EXPECT_TRUE(step.equilibria[1].is_chosen);
  EXPECT_TRUE(solve::select_lowest({end_at(1, 0, StepStatus::unbounded)}).equilibria.empty());
}

TEST(FreeSpine, OfEqualEnergiesTheEarlierStartCounts)
{
  EXPECT_EQ(solve::select_lowest({end_at(1.0, -5.0), end_at(2.0, -5.0 - 1e-7)}).chosen.pose.theta_rad,
            rad_from_deg(1.0));
  EXPECT_EQ(solve::select_lowest({end_at(1.0, -5.0), end_at(2.0, -5.0 - 1e-5)}).chosen.pose.theta_rad,
            rad_from_deg(2.0));
}

TEST(FreeSpine, WithoutAnEquilibriumTheFirstResultIsChosen)
{
  const solve::FreeSpineStep step =
      solve::select_lowest({end_at(1, 0, StepStatus::unbounded), end_at(2, 0, StepStatus::no_contact)});
  EXPECT_EQ(step.chosen.status, StepStatus::unbounded);
  EXPECT_EQ(step.n_optima, 0);
  EXPECT_EQ(step.theta_spread_rad, 0.0);
}

solve::SweepPlan plan_of(int n_flexion, int n_varus)
{
  solve::SweepPlan plan;
  for (int i = 0; i < n_flexion; ++i) plan.flexion_rad.push_back(rad_from_deg(5.0 * i));
  for (int j = 0; j < n_varus; ++j) plan.varus_rad.push_back(rad_from_deg(2.0 * (j - n_varus / 2)));
  plan.initial = {{0, -20, 0}, 0};
  plan.spine = solve::SpineRule::free_varus;
  plan.n_restarts = 3;
  plan.has_band = true;
  return plan;
}

// Two potential wells in theta at +-5 degrees, the right one deeper from 22 degrees of flexion; every start
// ends in the well of its own side. Varus is a tenth of flexion; theta depends on the seed's height.
StepRecord in_wells(const solve::StepTask& task)
{
  StepRecord record;
  record.status = StepStatus::stable;
  const bool is_right = task.seed.theta_rad > 0.0;
  record.pose = task.seed;
  record.pose.theta_rad = rad_from_deg((is_right ? 5.0 : -5.0) + 2.0 * task.band);
  record.pose.translation_mm = {0.0, 1e-4 * task.seed.translation_mm.y() + task.attitude.flexion_rad, 0.0};
  record.varus_rad = task.is_varus_free ? 0.1 * task.attitude.flexion_rad : task.attitude.varus_rad;
  const double tilt = rad_from_deg(22.0) - task.attitude.flexion_rad;
  record.balance.energy_nmm = is_right ? tilt : -tilt;
  return record;
}

TEST(FreeSpine, ACoarserGridOnTheSamePathHasTheSameSpine)
{
  const solve::SweepPlan fine = plan_of(13, 3);
  solve::SweepPlan coarse = fine;
  coarse.path_flexion_rad = fine.flexion_rad;
  coarse.flexion_rad = {fine.flexion_rad[0], fine.flexion_rad[4], fine.flexion_rad[12]};
  const solve::SweepResult of_fine = solve::sweep(fine, in_wells, {}, 2);
  const solve::SweepResult of_coarse = solve::sweep(coarse, in_wells, {}, 2);
  ASSERT_EQ(of_coarse.free_spine.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const StepRecord &found = of_coarse.free_spine[k].chosen,
                     &expected = of_fine.free_spine[4 * k + (k == 2 ? 4 : 0)].chosen;
    EXPECT_EQ(found.pose.theta_rad, expected.pose.theta_rad);
    EXPECT_EQ(found.pose.translation_mm, expected.pose.translation_mm);
    EXPECT_EQ(found.balance.energy_nmm, expected.balance.energy_nmm);
  }
}

// Energies fall in steps of a tenth of a degree towards 1 degree, as over facets.
TEST(FreeSpine, SmallOffsetsDescendOverFacets)
{
  solve::SweepPlan plan = plan_of(1, 1);
  const auto over_facets = [](const solve::StepTask& task) {
    StepRecord record;
    record.status = StepStatus::stable;
    record.pose.theta_rad = rad_from_deg(0.1 * std::round(10.0 * deg_from_rad(task.seed.theta_rad)));
    record.balance.energy_nmm = std::abs(deg_from_rad(record.pose.theta_rad) - 1.0);
    return record;
  };
  EXPECT_NEAR(deg_from_rad(solve::sweep(plan, over_facets, {}, 1).free_spine[0].chosen.pose.theta_rad), 1.0,
              1e-9);
}

TEST(FreeSpine, EachFlexionKeepsTheLowestOfBothChainsAndTheRestarts)
{
  const solve::SweepPlan plan = plan_of(10, 5);
  const solve::SweepResult result = solve::sweep(plan, in_wells, {}, 2);
  ASSERT_TRUE(result.is_complete);
  ASSERT_EQ(result.free_spine.size(), plan.flexion_rad.size());
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) {
    SCOPED_TRACE(i);
    const solve::FreeSpineStep& step = result.free_spine[i];
    const double well_deg = plan.flexion_rad[i] < rad_from_deg(22.0) ? -5.0 : 5.0;
    EXPECT_DOUBLE_EQ(step.chosen.pose.theta_rad, rad_from_deg(well_deg));
    EXPECT_DOUBLE_EQ(step.chosen.varus_rad, 0.1 * plan.flexion_rad[i]);
    EXPECT_EQ(step.n_optima, 2);
    EXPECT_DOUBLE_EQ(step.theta_spread_rad, 2.0 * rad_from_deg(5.0));
    // The band is solved from the chosen pose: it stays in the same well.
    EXPECT_DOUBLE_EQ(step.band_low.pose.theta_rad, rad_from_deg(well_deg - 2.0));
    EXPECT_DOUBLE_EQ(step.band_high.pose.theta_rad, rad_from_deg(well_deg + 2.0));
    const auto column = static_cast<std::size_t>(result.spine_column[i]);
    for (const double other : plan.varus_rad) {
      EXPECT_LE(std::abs(plan.varus_rad[column] - step.chosen.varus_rad),
                std::abs(other - step.chosen.varus_rad) + 1e-12);
    }
    EXPECT_DOUBLE_EQ(result.cells[i * 5].pose.theta_rad, rad_from_deg(well_deg)) << "rows start from there";
    EXPECT_EQ(result.cells[i * 5].varus_rad, plan.varus_rad[0]);
  }
}

TEST(FreeSpine, ALowerEquilibriumIsPropagatedToNeighbouringFlexions)
{
  const solve::SweepPlan plan = plan_of(8, 3);
  // The right well is lower everywhere, but only the restarts at 15 degrees reach it directly.
  const solve::SolveStep hidden = [&](const solve::StepTask& task) {
    solve::StepTask seen = task;
    const bool is_restart = task.key.kind == StepKind::free_spine && task.key.varus >= 2 &&
                            task.key.varus < 2 + plan.n_restarts && task.key.flexion != 3;
    if (is_restart) seen.seed.theta_rad = -1.0;
    StepRecord record = in_wells(seen);
    record.balance.energy_nmm = record.pose.theta_rad > 0.0 ? -1.0 : 0.0;
    return record;
  };
  for (const int n_threads : {1, 3}) {
    const solve::SweepResult result = solve::sweep(plan, hidden, {}, n_threads);
    for (const solve::FreeSpineStep& step : result.free_spine) {
      EXPECT_DOUBLE_EQ(step.chosen.pose.theta_rad, rad_from_deg(5.0));
      EXPECT_EQ(step.n_optima, 2);
    }
  }
}

TEST(FreeSpine, EachStartKnowsTheEarlierOnesOfItsRow)
{
  const solve::SweepPlan plan = plan_of(5, 3);
  std::vector<std::size_t> n_started(5, 0);
  const solve::SolveStep counting = [&](const solve::StepTask& task) {
    const bool is_start = task.key.kind == StepKind::free_spine;
    EXPECT_EQ(task.known != nullptr, is_start);
    if (is_start) {
      EXPECT_EQ(task.known->size(), n_started[static_cast<std::size_t>(task.key.flexion)]++);
    }
    return in_wells(task);
  };
  solve::sweep(plan, counting, {}, 1);
  for (const std::size_t n : n_started) EXPECT_GE(n, 2u + 3u + 6u + 1u);
}

TEST(FreeSpine, WithVarusFreeTheOneColumnHoldsTheSpine)
{
  solve::SweepPlan plan = plan_of(6, 1);
  plan.varus_rad = {0.0};
  plan.is_varus_free = true;
  const solve::SweepResult result = solve::sweep(plan, in_wells, {}, 1);
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) {
    EXPECT_EQ(result.cells[i].pose.theta_rad, result.free_spine[i].chosen.pose.theta_rad);
    EXPECT_EQ(result.cells[i].varus_rad, result.free_spine[i].chosen.varus_rad);
    EXPECT_EQ(result.spine_column[i], 0);
  }
}

TEST(FreeSpine, AnyNumberOfWorkersAndAnyInterruptionGiveTheSameBits)
{
  const solve::SweepPlan plan = plan_of(12, 5);
  const auto numbers = [](const solve::SweepResult& result) {
    std::vector<double> all;
    for (const StepRecord& r : result.cells) {
      all.insert(all.end(), {r.pose.translation_mm.y(), r.pose.theta_rad, r.varus_rad});
    }
    for (const solve::FreeSpineStep& s : result.free_spine) {
      all.insert(all.end(), {s.chosen.pose.translation_mm.y(), s.band_low.pose.translation_mm.y(),
                             static_cast<double>(s.n_optima), s.energy_spread_nmm});
    }
    return all;
  };
  const std::vector<double> one = numbers(solve::sweep(plan, in_wells, {}, 1));
  for (const int n : {2, 3, 8}) EXPECT_EQ(numbers(solve::sweep(plan, in_wells, {}, n)), one) << n;

  std::map<StepKey, StepRecord> journal;
  std::mutex mutex;
  int n_runs = 0;
  solve::SweepResult last;
  while (!last.is_complete) {
    ++n_runs;
    int budget = 37;
    solve::SweepHooks hooks;
    hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
      const std::lock_guard lock(mutex);
      const auto found = journal.find(key);
      return found == journal.end() ? std::nullopt : std::optional(found->second);
    };
    hooks.keep = [&](const StepRecord& r) {
      const std::lock_guard lock(mutex);
      EXPECT_TRUE(journal.emplace(r.key, r).second) << "solved twice";
    };
    hooks.is_stopped = [&] {
      const std::lock_guard lock(mutex);
      return budget-- <= 0;
    };
    last = solve::sweep(plan, in_wells, hooks, 2);
  }
  EXPECT_GT(n_runs, 2);
  EXPECT_EQ(numbers(last), one);
}

TEST(FreeSpine, AFlexionWithoutEquilibriumIsSkipped)
{
  const solve::SweepPlan plan = plan_of(5, 3);
  const solve::SolveStep with_hole = [&](const solve::StepTask& task) {
    StepRecord r = in_wells(task);
    if (task.key.flexion == 2) r.status = StepStatus::unbounded;
    return r;
  };
  const solve::SweepResult result = solve::sweep(plan, with_hole, {}, 1);
  ASSERT_TRUE(result.is_complete);
  EXPECT_EQ(result.free_spine[2].chosen.status, StepStatus::unbounded);
  EXPECT_EQ(result.free_spine[2].band_low.status, StepStatus::pending);
  EXPECT_EQ(result.free_spine[3].chosen.status, StepStatus::stable);
}

}  // namespace vrda::free_spine_test
