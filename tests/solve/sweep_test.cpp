#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <stdexcept>

#include "core/units.hpp"
#include "solve/case_solver.hpp"
#include "solve/sweep.hpp"
#include "support/meshes.hpp"

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
  r.gap_mm[0] = std::max(0.0, 40.0 * (attitude.varus_rad - balance_rad));
  r.gap_mm[1] = std::max(0.0, -40.0 * (attitude.varus_rad - balance_rad));
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

struct Interrupted {
  solve::SweepResult result;
  int n_runs = 0;
};

// The plan solved on two threads by runs that each stop after `n_steps` checks and resume from a journal; no
// step is solved twice.
Interrupted interrupted_sweep(const solve::SweepPlan& plan, const solve::SolveStep& step, int n_steps)
{
  std::map<StepKey, StepRecord> journal;
  std::mutex mutex;
  Interrupted last;
  while (!last.result.is_complete) {
    ++last.n_runs;
    int budget = n_steps;
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
    last.result = solve::sweep(plan, step, hooks, 2);
  }
  return last;
}

TEST(Sweep, AResumedRunSolvesNothingTwiceAndGivesTheSameBits)
{
  const solve::SweepPlan plan = plan_of(10, 7);
  const Interrupted resumed = interrupted_sweep(plan, drift, 23);
  EXPECT_GT(resumed.n_runs, 3);
  EXPECT_EQ(numbers(resumed.result), numbers(solve::sweep(plan, drift, {}, 1)));
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
    r.is_in_contact[0] = r.is_in_contact[1] = from_peak > rad_from_deg(-0.5) && from_peak < rad_from_deg(6.5);
    r.gap_mm[0] = r.is_in_contact[1] ? 0.0 : std::abs(from_peak);
    r.gap_mm[1] = 0.0;
    return r;
  };
  EXPECT_EQ(solve::sweep(plan, locked, {}, 1).spine_column, std::vector<std::int32_t>(3, 6));
}

TEST(Sweep, WithoutCompartmentsTheSpineStaysNearestZero)
{
  solve::SweepPlan plan = plan_of(4, 7);
  plan.spine = solve::SpineRule::nearest_zero;
  const solve::SweepResult result = solve::sweep(plan, drift, {}, 1);
  EXPECT_EQ(result.spine_column, std::vector<std::int32_t>(4, 3));
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

// Degrees of rotation; no more than 2 for a jump.
const solve::ChangePenalty per_degree = [](const solve::PathPoint& from, const solve::PathPoint& to) {
  return std::min(std::abs(deg_from_rad(to.pose.theta_rad - from.pose.theta_rad)), 2.0);
};

std::vector<double> thetas_of(const std::vector<solve::FreeSpineStep>& path)
{
  std::vector<double> thetas_deg;
  for (const solve::FreeSpineStep& step : path)
    thetas_deg.push_back(deg_from_rad(step.chosen.pose.theta_rad));
  return thetas_deg;
}

// Branches at 0 and 8 degrees: by these gains the second is lower.
TEST(FreeSpine, TheContinuousPathChangesBranchOnceAndOnlyForALowerSum)
{
  const std::vector<double> gains{-3, 1, 1, -1, 3, 3};
  std::vector<std::vector<StepRecord>> ends;
  std::vector<std::int32_t> rows;
  for (const double gain : gains) {
    rows.push_back(static_cast<std::int32_t>(ends.size()));
    ends.push_back({end_at(0.0, 100.0), end_at(8.0, 100.0 - gain)});
  }
  std::vector<double> lowest_deg;
  for (const std::vector<StepRecord>& of_flexion : ends)
    lowest_deg.push_back(deg_from_rad(solve::select_lowest(of_flexion).chosen.pose.theta_rad));
  EXPECT_EQ(lowest_deg, (std::vector<double>{0, 8, 8, 0, 8, 8})) << "three jumps";
  // Sums above the lowest plus changes: to 8 at the second flexion 2 + 1, at the fifth 1 + 1 + 2, at none 4.
  EXPECT_EQ(thetas_of(solve::select_continuous(ends, rows, per_degree)),
            (std::vector<double>{0, 8, 8, 8, 8, 8}));
  ends[3][1] = end_at(8.0, 102.5);  // 2.5 above the lowest: now the later change is cheaper
  EXPECT_EQ(thetas_of(solve::select_continuous(ends, rows, per_degree)),
            (std::vector<double>{0, 0, 0, 0, 8, 8}));
  ends[1][0] = end_at(0.0, 104.5);  // 5.5 above the lowest, more than a change both ways: never taken
  const std::vector<solve::FreeSpineStep> path = solve::select_continuous(ends, rows, per_degree);
  EXPECT_EQ(path[1].chosen.pose.theta_rad, rad_from_deg(8.0));
  EXPECT_FALSE(path[1].equilibria[0].is_chosen);
  EXPECT_TRUE(path[1].equilibria[1].is_chosen);
  EXPECT_EQ(path[1].n_optima, 2);
  EXPECT_EQ(path[1].energy_spread_nmm, 5.5) << "as with the lowest";
}

// F min(d^2 / 10 mm, 0.5 mm): 20 N along Delta and 5 N of a line, a lever of 15 mm.
TEST(FreeSpine, ThePenaltyOfAJobIsThatOfItsSchema)
{
  job::Case job_case;
  job_case.method = "equilibrium";
  job_case.moving.contact.mesh = test::box({4, 1, 2}, {30, 6, 20});
  job_case.grid = {{0.0, 1.0}, {0.0}};
  job_case.path_flexion_deg = {0.0, 1.0};
  job_case.path_push.resize(2);
  job_case.path_push[1].line_tension_n = {5.0};
  EXPECT_FALSE(solve::plan_of(job_case).change_penalty_nmm);
  job_case.spine.branch = BranchRule::continuous;
  const solve::ChangePenalty penalty_nmm = solve::plan_of(job_case).change_penalty_nmm;
  const solve::PathPoint from{{{1, 2, 3}, 0.2}, 0.1, 0};
  const auto to = [](const Eigen::Vector3d& t_mm, double theta_rad, double varus_rad) {
    return solve::PathPoint{{t_mm, theta_rad}, varus_rad, 1};
  };
  const auto turned_about_middle = [](const Eigen::Vector3d& t_mm, double from_rad, double to_rad) {
    const Eigen::Vector3d middle_mm(4, 0, 2);
    return Eigen::Vector3d(t_mm + rotation_y(from_rad) * middle_mm - rotation_y(to_rad) * middle_mm);
  };
  constexpr double rounding = 1e-12;
  EXPECT_EQ(penalty_nmm(from, to({1, 2, 3}, 0.2, 0.1)), 0.0);
  EXPECT_NEAR(penalty_nmm(from, to({1.3, 2, 3.4}, 0.2, 0.1)), 25 * 0.25 / 10, rounding);
  EXPECT_NEAR(penalty_nmm(from, to(turned_about_middle({1, 2, 3}, 0.2, 0.24), 0.24, 0.13)), 25 * 0.5625 / 10,
              rounding);
  EXPECT_EQ(penalty_nmm(from, to({5, 2, 3}, 0.2, 0.1)), 25 * 0.5);
}

// A flexion without a result or without an equilibrium does not end the path.
TEST(FreeSpine, TheContinuousPathPassesFlexionsWithoutEquilibrium)
{
  const std::vector<std::vector<StepRecord>> ends{{end_at(0, 0), end_at(8, 3)},
                                                  {end_at(4, -9, StepStatus::unbounded)},
                                                  {},
                                                  {end_at(8, -0.5), end_at(0, 0)}};
  const std::vector<solve::FreeSpineStep> path = solve::select_continuous(ends, {0, 1, 2, 3}, per_degree);
  EXPECT_EQ(path[0].chosen.pose.theta_rad, 0.0);
  EXPECT_EQ(path[1].chosen.status, StepStatus::unbounded);
  EXPECT_EQ(path[2].chosen.status, StepStatus::pending);
  EXPECT_EQ(path[3].chosen.pose.theta_rad, 0.0) << "half of what the change costs";
}

solve::SweepPlan free_plan_of(int n_flexion, int n_varus)
{
  solve::SweepPlan plan = plan_of(n_flexion, n_varus);
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
  const solve::SweepPlan fine = free_plan_of(13, 3);
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
  solve::SweepPlan plan = free_plan_of(1, 1);
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
  const solve::SweepPlan plan = free_plan_of(10, 5);
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

// A change costs 4, the right well before 22 degrees 2.1 in all, the left one after that 2.3: the spine, its
// band and its rows stay in the right one.
TEST(FreeSpine, RowsStartFromTheContinuousPath)
{
  solve::SweepPlan plan = free_plan_of(10, 5);
  plan.change_penalty_nmm = [](const solve::PathPoint& from, const solve::PathPoint& to) {
    return 2.0 * per_degree(from, to);
  };
  for (const int n_threads : {1, 3}) {
    const solve::SweepResult result = solve::sweep(plan, in_wells, {}, n_threads);
    for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) {
      EXPECT_DOUBLE_EQ(result.free_spine[i].chosen.pose.theta_rad, rad_from_deg(5.0));
      EXPECT_EQ(result.free_spine[i].n_optima, 2);
      EXPECT_DOUBLE_EQ(result.free_spine[i].band_high.pose.theta_rad, rad_from_deg(7.0));
      EXPECT_DOUBLE_EQ(result.cells[i * 5].pose.theta_rad, rad_from_deg(5.0));
    }
  }
}

TEST(FreeSpine, ALowerEquilibriumIsPropagatedToNeighbouringFlexions)
{
  const solve::SweepPlan plan = free_plan_of(8, 3);
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

TEST(FreeSpine, WithVarusFreeTheOneColumnHoldsTheSpine)
{
  solve::SweepPlan plan = free_plan_of(6, 1);
  plan.varus_rad = {0.0};
  plan.is_varus_free = true;
  const solve::SweepResult result = solve::sweep(plan, in_wells, {}, 1);
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) {
    EXPECT_EQ(result.cells[i].pose.theta_rad, result.free_spine[i].chosen.pose.theta_rad);
    EXPECT_EQ(result.cells[i].varus_rad, result.free_spine[i].chosen.varus_rad);
    EXPECT_EQ(result.spine_column[i], 0);
  }
}

std::vector<double> numbers_of_spine(const solve::SweepResult& result)
{
  std::vector<double> all;
  for (const StepRecord& r : result.cells)
    all.insert(all.end(), {r.pose.translation_mm.y(), r.pose.theta_rad, r.varus_rad});
  for (const solve::FreeSpineStep& s : result.free_spine) {
    all.insert(all.end(), {s.chosen.pose.translation_mm.y(), s.band_low.pose.translation_mm.y(),
                           static_cast<double>(s.n_optima), s.energy_spread_nmm});
  }
  return all;
}

TEST(FreeSpine, AnyNumberOfWorkersAndAnyInterruptionGiveTheSameBits)
{
  const solve::SweepPlan plan = free_plan_of(12, 5);
  const std::vector<double> one = numbers_of_spine(solve::sweep(plan, in_wells, {}, 1));
  for (const int n : {2, 3, 8}) EXPECT_EQ(numbers_of_spine(solve::sweep(plan, in_wells, {}, n)), one) << n;

  const Interrupted resumed = interrupted_sweep(plan, in_wells, 37);
  EXPECT_GT(resumed.n_runs, 2);
  EXPECT_EQ(numbers_of_spine(resumed.result), one);
}

TEST(FreeSpine, AFlexionWithoutEquilibriumIsSkipped)
{
  const solve::SweepPlan plan = free_plan_of(5, 3);
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

}  // namespace vrda::sweep_test
