// Springs of a prior: their coordinates against the clinical ones, derivatives, closed form, and the
// estimation of level and factor over a sweep.
#include "solve/prior.hpp"

#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <random>

#include "core/units.hpp"
#include "solve/case_solver.hpp"
#include "solve/pins.hpp"
#include "solve/potential.hpp"
#include "solve/sweep.hpp"

namespace vrda::prior_test {

struct At {
  double flexion_rad, varus_rad;
  MovingPose pose;
};

std::vector<At> random_poses()
{
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<At> all;
  for (int k = 0; k < 20; ++k) {
    At& at = all.emplace_back();
    at.flexion_rad = 1.5 * unit(engine);
    at.varus_rad = 0.4 * unit(engine);
    at.pose.theta_rad = unit(engine);
    for (double& mm : at.pose.translation_mm) mm = 10.0 * unit(engine);
  }
  return all;
}

constexpr double rounding = 1e-12;

TEST(PriorCoordinates, AreTheClinicalOnesOfBothSides)
{
  for (const Side side : {Side::right, Side::left}) {
    for (const At& at : random_poses()) {
      SolverFrame frame;
      frame.side = side;
      const ClinicalCoordinates q = clinical_coordinates(
          X_reference_moving(frame, {at.flexion_rad, at.varus_rad}, at.pose), side, Eigen::Vector3d::Zero());
      const auto value = [&](PriorCoordinate coordinate) {
        return solve::coordinate_value(coordinate, at.varus_rad, at.pose).value;
      };
      EXPECT_NEAR(value(PriorCoordinate::varus), q.varus_rad, rounding);
      EXPECT_NEAR(value(PriorCoordinate::internal), q.internal_rotation_rad, rounding);
      EXPECT_NEAR(value(PriorCoordinate::anterior), q.anterior_mm, 20 * rounding);
      EXPECT_NEAR(value(PriorCoordinate::proximal), q.proximal_mm, 20 * rounding);
      EXPECT_NEAR(value(PriorCoordinate::lateral), q.lateral_mm, 20 * rounding);
    }
  }
}

TEST(PriorCoordinates, CentreAnteriorIsThatOfTheRotationCentreOnTheMovingBody)
{
  for (const At& at : random_poses()) {
    const Pose X = X_reference_moving(SolverFrame{}, {at.flexion_rad, at.varus_rad}, at.pose);
    const Eigen::Vector3d p_moving = X.inverse() * Eigen::Vector3d::Zero();
    EXPECT_NEAR(solve::coordinate_value(PriorCoordinate::centre_anterior, at.varus_rad, at.pose).value,
                p_moving.x(), 20 * rounding);
  }
}

TEST(PriorSprings, HaveTheDerivativesOfTheirEnergy)
{
  constexpr double h = 1e-5, difference = 1e-4;  // of energies up to 1e4 N mm
  for (const At& at : random_poses()) {
    for (const PriorCoordinate coordinate : all_prior_coordinates) {
      SCOPED_TRACE(name_of(coordinate));
      const std::vector<CoordinateSpring> springs{{coordinate, 30.0, 0.7}};
      const Potential here = solve::energy_of(springs, at.varus_rad, at.pose);
      for (Eigen::Index k = 0; k < n_coordinates; ++k) {
        const auto there = [&](double step) {
          MovingPose pose = at.pose;
          if (k < 3) pose.translation_mm(k) += step;
          if (k == about_y) pose.theta_rad += step;
          return solve::energy_of(springs, at.varus_rad + (k == about_varus ? step : 0.0), pose);
        };
        const Potential up = there(h), down = there(-h);
        EXPECT_NEAR(here.gradient(k), (up.energy_nmm - down.energy_nmm) / (2 * h), difference);
        const Vector5d column = (up.gradient - down.gradient) / (2 * h);
        EXPECT_LT((here.hessian.col(k) - column).norm(), difference);
      }
    }
  }
}

// A tip under y = -x^2 / 2R, pushed by F: k (x - x0) = -F x / R. In the middle of a facet its slope is that
// of the parabola.
TEST(PriorSprings, HoldATipInADishWhereTheForcesBalance)
{
  constexpr double R_mm = 50.0, facet_mm = 0.2, x_mm = 3.1;
  const solve::Joint joint =
      test::joint_of(test::ceiling(20, 100, [](double x, double z) { return -(x * x + z * z) / (2 * R_mm); }),
                     test::pins({{0, 0, 0}}));
  Loads loads;
  const double k_n_per_mm = loads.force_n.y() / R_mm;
  loads.springs = {{PriorCoordinate::anterior, k_n_per_mm, 2 * x_mm}};
  const StepRecord end = solve::EquilibriumSolver(joint, {}, {}).solve({{}, {{1, -5, 0}, 0}, loads});
  ASSERT_EQ(end.status, StepStatus::stable);
  EXPECT_NEAR(end.pose.translation_mm.x(), x_mm, 1e-3) << "solver tolerance 1e-4 over its stiffness";
  EXPECT_LT(end.balance.residual_n, 1e-2 * loads.force_n.y());
  loads.springs.clear();
  const StepRecord free = solve::EquilibriumSolver(joint, {}, {}).solve({{}, {{1, -5, 0}, 0}, loads});
  EXPECT_NEAR(free.pose.translation_mm.x(), 0.0, facet_mm);
}

// The minimal knee over three flexions; its own rotation resists 1/2 own (theta - theta_0)^2.
class PriorSweep : public testing::Test {
 protected:
  PriorSweep()
  {
    plan_.flexion_rad = {0.0, 0.1, 0.2};
    plan_.varus_rad = {0.0};
    plan_.is_varus_free = true;
    plan_.spine = solve::SpineRule::free_varus;
    plan_.band_moment_nmm = 200.0;
    plan_.initial.translation_mm.y() = -5.0;
    PriorTerm term;
    term.shape = "table";
    term.flexion_rad = {0.0, 0.2};
    term.value = {0.0, 0.1};
    term.stiffness = 100.0;
    term.has_factor = true;
    term.times_own = 2.0;
    term.at_most_times = 1e6;
    plan_.prior = {term};
  }

  StepRecord solve(const solve::StepTask& task) const
  {
    Loads loads;
    loads.moment_nmm = task.band * plan_.band_moment_nmm;
    loads.springs = task.springs;
    return solve::EquilibriumSolver(knee_.joint, knee_.ligaments, {})
        .solve({task.attitude, task.seed, loads, task.is_varus_free, task.is_measured, task.known});
  }

  // `known`: recalled; new steps are added to it until `most` are solved.
  solve::SweepResult swept(std::map<StepKey, StepRecord>& known, int most = 1'000'000, int n_threads = 1)
  {
    std::mutex mutex;
    int n_solved = 0;
    solve::SweepHooks hooks;
    hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
      const std::lock_guard lock(mutex);
      const auto found = known.find(key);
      return found == known.end() ? std::nullopt : std::optional(found->second);
    };
    hooks.keep = [&](const StepRecord& record) {
      const std::lock_guard lock(mutex);
      known[record.key] = record;
      ++n_solved;
    };
    hooks.is_stopped = [&] {
      const std::lock_guard lock(mutex);
      return n_solved >= most;
    };
    return solve::sweep(
        plan_, [&](const solve::StepTask& task) { return solve(task); }, hooks, n_threads);
  }

  test::MinimalKnee knee_;
  solve::SweepPlan plan_;
};

TEST_F(PriorSweep, AloneItIsTheSweepWithoutPrior)
{
  std::map<StepKey, StepRecord> none, known;
  const solve::SweepResult with = swept(known);
  plan_.prior.clear();
  const solve::SweepResult without = swept(none);
  ASSERT_EQ(with.alone.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(with.alone[i].chosen.pose.theta_rad, without.free_spine[i].chosen.pose.theta_rad);
    EXPECT_EQ(with.alone[i].chosen.pose.translation_mm, without.free_spine[i].chosen.pose.translation_mm);
    EXPECT_NE(with.free_spine[i].chosen.pose.theta_rad, without.free_spine[i].chosen.pose.theta_rad);
  }
}

TEST_F(PriorSweep, TheFreeLevelBalancesTheSprings)
{
  std::map<StepKey, StepRecord> known;
  const solve::SweepResult result = swept(known);
  double sum_nmm = 0.0, size_nmm = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const CoordinateSpring spring =
        solve::springs_at(plan_.prior, result.prior, plan_.flexion_rad[i]).front();
    EXPECT_NEAR(spring.stiffness, std::max(100.0, 2.0 * result.prior.own_stiffness[i]), 1e-9);
    const double off_rad = result.free_spine[i].chosen.pose.theta_rad - spring.target;
    sum_nmm += spring.stiffness * off_rad;
    size_nmm += spring.stiffness * std::abs(off_rad);
  }
  ASSERT_GT(size_nmm, 10.0) << "the springs pull";
  EXPECT_LT(std::abs(sum_nmm), 0.05 * size_nmm) << "four estimations of the level";
}

TEST_F(PriorSweep, AGivenLevelIsKept)
{
  plan_.prior.front().level = 0.05;
  std::map<StepKey, StepRecord> known;
  EXPECT_EQ(swept(known).prior.level, std::vector<double>{0.05});
}

// A curve that is shifted as a whole has another level and the same motion, if the level is free.
TEST_F(PriorSweep, ASampleEstimatesAFreeLevelAgain)
{
  constexpr double shift_rad = 0.04;
  for (const bool is_free : {true, false}) {
    if (!is_free) plan_.prior.front().level = 0.0;
    std::map<StepKey, StepRecord> known;
    const solve::SweepResult job = swept(known);
    solve::SampleOptions options;
    options.prior = plan_.prior;
    for (double& value : options.prior.front().value) value += shift_rad;
    const solve::SolveStep solve = [&](const solve::StepTask& task) { return this->solve(task); };
    const std::vector<StepRecord> sample = solve::sample_motion(plan_, job, solve, options);
    ASSERT_EQ(sample.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      const double moved_rad = sample[i].pose.theta_rad - job.free_spine[i].chosen.pose.theta_rad;
      // Springs twice as stiff as the joint take two thirds of a shift; the estimations, a twentieth of it.
      EXPECT_NEAR(moved_rad, is_free ? 0.0 : 2.0 / 3.0 * shift_rad, (is_free ? 0.05 : 0.2) * shift_rad);
    }
  }
}

TEST_F(PriorSweep, IsTheSameForThreadsAndInterruptions)
{
  std::map<StepKey, StepRecord> known, four, parts;
  const solve::SweepResult whole = swept(known);
  const solve::SweepResult of_four = swept(four, 1'000'000, 4);
  solve::SweepResult resumed;
  int n_runs = 0;
  for (; !resumed.is_complete && n_runs < 100; ++n_runs) resumed = swept(parts, 7);
  EXPECT_GT(n_runs, 5);
  for (const solve::SweepResult* other : {&of_four, &std::as_const(resumed)}) {
    ASSERT_TRUE(other->is_complete);
    EXPECT_EQ(other->prior.level, whole.prior.level);
    EXPECT_EQ(other->prior.own_stiffness, whole.prior.own_stiffness);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(other->cells[i].pose.theta_rad, whole.cells[i].pose.theta_rad);
  }
  EXPECT_EQ(parts.size(), known.size());
}

}  // namespace vrda::prior_test
