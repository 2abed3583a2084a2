#include "solve/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "core/units.hpp"

namespace vrda::sweep_test {

solve::SweepPlan plan_of(int n_flexion, int n_varus)
{
  solve::SweepPlan plan;
  for (int i = 0; i < n_flexion; ++i) plan.flexion_rad.push_back(rad_from_deg(5.0 * i));
  for (int j = 0; j < n_varus; ++j) plan.varus_rad.push_back(rad_from_deg(2.0 * (j - n_varus / 2)));
  plan.initial = {{0, -20, 0}, 0};
  return plan;
}

// A joint whose balanced varus changes with flexion and whose pose depends on its seed, which reveals any
// other seeding order.
StepRecord drifting(const Attitude& attitude, const MovingPose& seed)
{
  StepRecord r;
  r.status = StepStatus::stable;
  r.pose.translation_mm =
      0.5 * seed.translation_mm + Eigen::Vector3d(attitude.flexion_rad, attitude.varus_rad, 1);
  r.pose.theta_rad = 0.9 * seed.theta_rad + attitude.flexion_rad;
  const double balance_rad = 0.1 * attitude.flexion_rad;
  r.gap_medial_mm = std::max(0.0, 40.0 * (attitude.varus_rad - balance_rad));
  r.gap_lateral_mm = std::max(0.0, -40.0 * (attitude.varus_rad - balance_rad));
  return r;
}

const solve::SolveStep drift = [](const solve::StepTask& task) { return drifting(task.attitude, task.seed); };

std::vector<double> numbers(const solve::SweepResult& result)
{
  std::vector<double> all;
  for (const StepRecord& r : result.cells) {
    all.insert(all.end(), {r.pose.translation_mm.x(), r.pose.translation_mm.y(), r.pose.translation_mm.z(),
                           r.pose.theta_rad, static_cast<double>(r.status)});
  }
  return all;
}

TEST(Sweep, TheSpineFollowsTheBalanceAndRowsGrowOutward)
{
  const solve::SweepPlan plan = plan_of(12, 9);
  const solve::SweepResult result = solve::sweep(plan, drift, {}, 1);
  ASSERT_TRUE(result.is_complete);
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) {
    const double balance_rad = 0.1 * plan.flexion_rad[i];
    const auto spine = static_cast<std::size_t>(result.spine_column[i]);
    for (const double other : plan.varus_rad) {
      EXPECT_LE(std::abs(plan.varus_rad[spine] - balance_rad), std::abs(other - balance_rad) + 1e-12);
    }
    const auto cell = [&](std::size_t j) { return result.cells[i * plan.varus_rad.size() + j]; };
    for (std::size_t j = spine + 1; j < plan.varus_rad.size(); ++j) {
      const StepRecord expected = drifting({plan.flexion_rad[i], plan.varus_rad[j]}, cell(j - 1).pose);
      EXPECT_EQ(cell(j).pose.translation_mm, expected.pose.translation_mm);
    }
    for (std::size_t j = spine; j-- > 0;) {
      const StepRecord expected = drifting({plan.flexion_rad[i], plan.varus_rad[j]}, cell(j + 1).pose);
      EXPECT_EQ(cell(j).pose.translation_mm, expected.pose.translation_mm);
    }
  }
}

TEST(Sweep, AnyNumberOfWorkersGivesTheSameBits)
{
  const solve::SweepPlan plan = plan_of(20, 11);
  const std::vector<double> one = numbers(solve::sweep(plan, drift, {}, 1));
  for (const int n : {2, 3, 8}) EXPECT_EQ(numbers(solve::sweep(plan, drift, {}, n)), one) << n;
}

TEST(Sweep, AResumedRunSolvesNothingTwiceAndGivesTheSameBits)
{
  const solve::SweepPlan plan = plan_of(10, 7);
  const std::vector<double> whole = numbers(solve::sweep(plan, drift, {}, 1));
  std::map<StepKey, StepRecord> journal;
  std::mutex mutex;
  int n_solved = 0, n_runs = 0;
  bool is_complete = false;
  std::vector<double> last;
  while (!is_complete) {
    ++n_runs;
    int budget = 23;
    solve::SweepHooks hooks;
    hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
      const std::lock_guard lock(mutex);
      const auto found = journal.find(key);
      return found == journal.end() ? std::nullopt : std::optional(found->second);
    };
    hooks.keep = [&](const StepRecord& r) {
      const std::lock_guard lock(mutex);
      EXPECT_TRUE(journal.emplace(r.key, r).second) << "solved twice";
      n_solved += r.key.kind == StepKind::spine ? 0 : 1;
    };
    hooks.is_stopped = [&] {
      const std::lock_guard lock(mutex);
      return budget-- <= 0;
    };
    const solve::SweepResult result = solve::sweep(plan, drift, hooks, 2);
    is_complete = result.is_complete;
    last = numbers(result);
  }
  EXPECT_GT(n_runs, 3);
  EXPECT_EQ(last, whole);
}

TEST(Sweep, AFailedCellIsSkippedAndTheSweepContinues)
{
  const solve::SweepPlan plan = plan_of(3, 7);
  const solve::SolveStep with_hole = [&](const solve::StepTask& task) {
    StepRecord r = drifting(task.attitude, task.seed);
    if (std::abs(task.attitude.varus_rad - plan.varus_rad[5]) < 1e-9) r.status = StepStatus::no_contact;
    return r;
  };
  const solve::SweepResult result = solve::sweep(plan, with_hole, {}, 2);
  EXPECT_TRUE(result.is_complete);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(result.cells[i * 7 + 5].status, StepStatus::no_contact);
    const StepRecord expected =
        drifting({plan.flexion_rad[i], plan.varus_rad[6]}, result.cells[i * 7 + 4].pose);
    EXPECT_EQ(result.cells[i * 7 + 6].pose.translation_mm, expected.pose.translation_mm);
  }
}

TEST(Sweep, AFailedSpineSeedsItsRowFromTheLastStableSpine)
{
  const solve::SweepPlan plan = plan_of(3, 5);
  const solve::SolveStep failing_row = [&](const solve::StepTask& task) {
    StepRecord r = drifting(task.attitude, task.seed);
    if (std::abs(task.attitude.flexion_rad - plan.flexion_rad[1]) < 1e-9)
      r.status = StepStatus::iteration_limit;
    return r;
  };
  const solve::SweepResult result = solve::sweep(plan, failing_row, {}, 1);
  ASSERT_TRUE(result.is_complete);
  const auto first_spine = static_cast<std::size_t>(result.spine_column[0]);
  const auto third_spine = static_cast<std::size_t>(result.spine_column[2]);
  const StepRecord expected =
      drifting({plan.flexion_rad[2], plan.varus_rad[third_spine]}, result.cells[first_spine].pose);
  EXPECT_EQ(result.cells[2 * 5 + third_spine].pose.translation_mm, expected.pose.translation_mm);
}

TEST(Sweep, WithContactOnBothSidesTheSpineMaximisesTheHeight)
{
  // Both sides are in contact over six degrees of varus; the height is largest at 2 degrees.
  solve::SweepPlan plan = plan_of(3, 11);
  const solve::SolveStep locked = [](const solve::StepTask& task) {
    StepRecord r;
    r.status = StepStatus::stable;
    const double from_peak = task.attitude.varus_rad - rad_from_deg(2.0);
    r.pose.translation_mm.y() = -std::abs(from_peak);
    r.contact_medial = r.contact_lateral = from_peak > rad_from_deg(-0.5) && from_peak < rad_from_deg(6.5);
    r.gap_medial_mm = r.contact_lateral ? 0.0 : std::abs(from_peak);
    r.gap_lateral_mm = 0.0;
    return r;
  };
  EXPECT_EQ(solve::sweep(plan, locked, {}, 1).spine_column, std::vector<std::int32_t>(3, 6));
}

TEST(Sweep, BothTouchingBeatsOneAndOneStableBeatsNone)
{
  StepRecord both, one, failed;
  both.status = one.status = StepStatus::stable;
  both.contact_medial = both.contact_lateral = one.contact_medial = true;
  both.gap_medial_mm = 0.05;
  both.gap_lateral_mm = one.gap_medial_mm = 0.0;
  one.gap_lateral_mm = 0.02;
  failed.status = StepStatus::no_contact;
  EXPECT_TRUE(solve::is_better_balanced(both, one));
  EXPECT_FALSE(solve::is_better_balanced(one, both));
  EXPECT_TRUE(solve::is_better_balanced(one, failed));
  EXPECT_FALSE(solve::is_better_balanced(failed, one));
  EXPECT_FALSE(solve::is_better_balanced(failed, failed));
}

TEST(Sweep, WithoutCompartmentsTheSpineStaysNearestZero)
{
  solve::SweepPlan plan = plan_of(4, 7);
  plan.spine = solve::SpineRule::nearest_zero;
  const solve::SweepResult result = solve::sweep(plan, drift, {}, 1);
  EXPECT_EQ(result.spine_column, std::vector<std::int32_t>(4, 3));
}

TEST(Sweep, EachStepIsSolvedOnceUnderTheKeyItIsKeptWith)
{
  const solve::SweepPlan plan = plan_of(6, 7);
  std::mutex mutex;
  std::map<StepKey, int> solved, kept;
  const solve::SolveStep noting = [&](const solve::StepTask& task) {
    const std::lock_guard lock(mutex);
    ++solved[task.key];
    EXPECT_EQ(task.attitude.flexion_rad, plan.flexion_rad[static_cast<std::size_t>(task.key.flexion)]);
    EXPECT_EQ(task.attitude.varus_rad, plan.varus_rad[static_cast<std::size_t>(task.key.varus)]);
    return drifting(task.attitude, task.seed);
  };
  solve::SweepHooks hooks;
  hooks.keep = [&](const StepRecord& r) {
    const std::lock_guard lock(mutex);
    if (r.key.kind != StepKind::spine) ++kept[r.key];
  };
  const solve::SweepResult result = solve::sweep(plan, noting, hooks, 3);
  EXPECT_EQ(solved, kept);
  EXPECT_TRUE(std::all_of(solved.begin(), solved.end(), [](const auto& entry) { return entry.second == 1; }));
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) {
    EXPECT_EQ(solved.count({StepKind::spine_probe, static_cast<std::int32_t>(i), result.spine_column[i]}),
              1u);
  }
}

TEST(Sweep, RethrowsExceptionsOfTheSolver)
{
  std::atomic<int> n = 0;
  const solve::SolveStep throwing = [&](const solve::StepTask& task) {
    if (++n == 17) throw std::runtime_error("broken");
    return drifting(task.attitude, task.seed);
  };
  EXPECT_THROW(solve::sweep(plan_of(6, 6), throwing, {}, 3), std::runtime_error);
}

TEST(Sweep, AStepThatCannotBeKeptStopsTheOthersAfterTheirCurrentStep)
{
  constexpr int n_cells = 900, first_refused = 12;
  std::atomic<int> n_solved = 0, n_kept = 0;
  const solve::SolveStep counting = [&](const solve::StepTask& task) {
    // Slow after a refused step, so that the refusal takes effect long before the grid is solved.
    if (n_kept >= first_refused) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ++n_solved;
    return drifting(task.attitude, task.seed);
  };
  solve::SweepHooks hooks;
  hooks.keep = [&](const StepRecord&) {
    // Refuses one record only: a smaller record may fit on a full disk.
    if (++n_kept == first_refused) throw std::runtime_error("full");
  };
  EXPECT_THROW(solve::sweep(plan_of(30, 30), counting, hooks, 4), std::runtime_error);
  EXPECT_LT(n_solved, n_cells / 2);
}

// Solves only from a pose within 3 degrees of the attitude: the pose encodes the attitude in degrees.
StepRecord narrow(const solve::StepTask& task)
{
  StepRecord r;
  const Eigen::Vector3d at(deg_from_rad(task.attitude.flexion_rad), 0.0,
                           deg_from_rad(task.attitude.varus_rad));
  const bool is_near = (task.seed.translation_mm - at).cwiseAbs().maxCoeff() <= 3.0;
  r.status = is_near ? StepStatus::stable : StepStatus::no_clearance;
  r.pose.translation_mm = at;
  return r;
}

solve::SweepPlan coarse_plan()
{
  solve::SweepPlan plan;
  plan.flexion_rad = {0.0, rad_from_deg(10.0), rad_from_deg(20.0)};
  plan.varus_rad = {rad_from_deg(-7.0), 0.0, rad_from_deg(7.0)};
  plan.spine = solve::SpineRule::nearest_zero;
  return plan;
}

long n_stable(const solve::SweepResult& result)
{
  return std::count_if(result.cells.begin(), result.cells.end(),
                       [](const StepRecord& r) { return r.status == StepStatus::stable; });
}

TEST(Sweep, AStepThatFailsIsReachedThroughIntermediateAttitudes)
{
  solve::SweepPlan plan = coarse_plan();
  EXPECT_EQ(n_stable(solve::sweep(plan, narrow, {}, 1)), 1);
  plan.max_seed_step_rad = rad_from_deg(2.0);
  int n_kept = 0;
  solve::SweepHooks hooks;
  hooks.keep = [&](const StepRecord& r) {
    ++n_kept;
    // Intermediate attitudes are never kept.
    EXPECT_EQ(r.pose.translation_mm.x(), 10.0 * r.key.flexion);
  };
  const solve::SweepResult result = solve::sweep(plan, narrow, hooks, 1);
  EXPECT_EQ(n_stable(result), 9);
  EXPECT_EQ(n_kept, 9 + 3);  // the spine's cells also as probes
  plan.max_seed_step_rad = rad_from_deg(3.5);
  EXPECT_EQ(n_stable(solve::sweep(plan, narrow, {}, 1)), 1) << "parts above 3 degrees fail like the step";
}

TEST(Sweep, APoseOutsideTheJointIsReplacedAndSeedsNothing)
{
  // From a seed that is not the start pose the step ends outside from 10 degrees of flexion on.
  solve::SweepPlan plan = plan_of(4, 5);
  plan.max_seed_step_rad = rad_from_deg(2.0);
  plan.is_in_joint = [](const MovingPose& pose, std::int32_t) { return pose.translation_mm.y() < 50.0; };
  const solve::SolveStep sliding = [&](const solve::StepTask& task) {
    EXPECT_LT(task.seed.translation_mm.y(), 50.0);
    StepRecord r = drifting(task.attitude, task.seed);
    r.pose.translation_mm.y() = 1.0;
    const bool is_start = task.seed.translation_mm == plan.initial.translation_mm;
    if (task.attitude.flexion_rad > rad_from_deg(9.0) && !is_start) r.pose.translation_mm.y() = 300.0;
    return r;
  };
  for (const int n_threads : {1, 3}) {
    for (const StepRecord& r : solve::sweep(plan, sliding, {}, n_threads).cells)
      EXPECT_EQ(r.pose.translation_mm.y(), 1.0);
  }
}

TEST(Sweep, WithoutAPoseInTheJointTheLastStableResultIsKept)
{
  solve::SweepPlan plan = plan_of(1, 1);
  plan.max_seed_step_rad = rad_from_deg(2.0);
  plan.is_in_joint = [](const MovingPose&, std::int32_t) { return false; };
  EXPECT_EQ(solve::sweep(plan, drift, {}, 1).cells[0].status, StepStatus::stable);
  const solve::SolveStep failing = [](const solve::StepTask&) {
    StepRecord r;
    r.status = StepStatus::no_contact;
    return r;
  };
  EXPECT_EQ(solve::sweep(plan, failing, {}, 1).cells[0].status, StepStatus::no_contact);
}

TEST(Sweep, RotatedStartPosesAreTriedOnlyIfNothingElseIsStable)
{
  solve::SweepPlan plan = plan_of(1, 1);
  plan.max_seed_step_rad = rad_from_deg(2.0);
  plan.last_resort_thetas_rad = {-0.5, 0.5};
  int n_solved = 0;
  const solve::SolveStep turned_only = [&](const solve::StepTask& task) {
    ++n_solved;
    StepRecord r;
    r.status = task.seed.theta_rad > 0.4 ? StepStatus::stable : StepStatus::no_contact;
    r.pose = task.seed;
    return r;
  };
  EXPECT_EQ(solve::sweep(plan, turned_only, {}, 1).cells[0].pose.theta_rad, 0.5);
  EXPECT_EQ(n_solved, 3);
  plan.initial.theta_rad = 0.45;
  n_solved = 0;
  EXPECT_EQ(solve::sweep(plan, turned_only, {}, 1).cells[0].pose.theta_rad, 0.45);
  EXPECT_EQ(n_solved, 1);
}

TEST(Sweep, TheStableResultOfAnEarlierSeedIsSolvedLastForItsTrace)
{
  // The second row is stable outside the joint from the first row, and fails from the start pose.
  solve::SweepPlan plan = plan_of(2, 1);
  plan.max_seed_step_rad = rad_from_deg(5.0);  // one part: no intermediate attitudes
  plan.is_in_joint = [](const MovingPose& pose, std::int32_t row) {
    return row == 0 || pose.theta_rad > 9.0;
  };
  std::vector<Eigen::Vector3d> seeds;
  const solve::SolveStep failing_at_start = [&](const solve::StepTask& task) {
    StepRecord r = drifting(task.attitude, task.seed);
    if (task.key.flexion == 0) return r;
    seeds.push_back(task.seed.translation_mm);
    if (task.seed.translation_mm == plan.initial.translation_mm) r.status = StepStatus::no_contact;
    return r;
  };
  const solve::SweepResult result = solve::sweep(plan, failing_at_start, {}, 1);
  EXPECT_EQ(result.cells[1].status, StepStatus::stable);
  ASSERT_EQ(seeds.size(), 3u);
  EXPECT_EQ(seeds[1], plan.initial.translation_mm);
  EXPECT_EQ(seeds[2], result.cells[0].pose.translation_mm);
}

}  // namespace vrda::sweep_test
