// The equilibrium with ligaments and loads, with and without contact.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "solve/pins.hpp"

namespace vrda::equilibrium_loads_test {

const EquilibriumOptions options;
constexpr double standoff_mm = 1e-5;
constexpr double k_n = test::fibre_stiffness_n;  // of every fibre, per unit strain
constexpr double transition = 0.06;

using test::ceiling;
using test::fibre;
using test::joint_of;
using test::pins;

double flat(double, double)
{
  return 0.0;
}

// Pushed up by `push_n` towards a plate and pulled down by one fibre of slack length 40 mm from (0, -60, 0).
StepRecord tethered(double push_n)
{
  const solve::Joint joint = joint_of(ceiling(60, 4, flat), pins({{0, 0, 0}}));
  model::Ligaments ligaments;
  ligaments.fibres = {fibre({0, -60, 0}, {0, -15, 0}, 40)};
  Loads loads;
  loads.force_n = {0, push_n, 0};
  return solve::EquilibriumSolver(joint, ligaments, options).solve({{}, {{1, -20, 2}, 0.4}, loads, false});
}

TEST(EquilibriumLoads, AFibreHoldsThePushOffTheContact)
{
  // Beyond the toe region the tension is k (strain - transition / 2): 120 N stretch it by 9 %, to 43.6 mm.
  const StepRecord r = tethered(120);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR(r.pose.translation_mm.y(), 40 * (1 + 120 / k_n + 0.5 * transition) - 45, 1e-4);
  EXPECT_LT(std::hypot(r.pose.translation_mm.x(), r.pose.translation_mm.z()), 1e-4);
  EXPECT_TRUE(r.balance.forces.empty());
  EXPECT_TRUE(r.contacts.empty());
  EXPECT_FALSE(r.theta_determined);
  EXPECT_LT(r.balance.residual_n, 1e-3);
  EXPECT_NEAR(r.balance.worst_gap_mm, -r.pose.translation_mm.y(), 1e-6);
}

TEST(EquilibriumLoads, MorePushAndThePlateTakesTheRest)
{
  // At 45 mm the tension is k (0.125 - 0.03) = 190 N; the plate carries the remainder of 250 N.
  const StepRecord r = tethered(250);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR(r.pose.translation_mm.y(), -standoff_mm, 1e-7);
  ASSERT_EQ(r.balance.forces.size(), 1u);
  EXPECT_NEAR(r.balance.forces[0].along_delta_n, 60.0, 1e-2);
}

TEST(EquilibriumLoads, AMomentTurnsItAgainstTorsionSprings)
{
  // Four fibres of 30 mm at the corners of a square, each along Z: rotation stretches two.
  const solve::Joint joint = joint_of(ceiling(80, 4, flat), pins({{20, 0, 0}, {-20, 0, 0}, {0, 0, 0}}));
  model::Ligaments ligaments;
  for (const double x : {20.0, -20.0}) {
    for (const double z : {30.0, -30.0}) ligaments.fibres.push_back(fibre({x, -10, z}, {x, -10, 0}, 29));
  }
  Loads loads;
  loads.moment_nmm = 800;
  const StepRecord r =
      solve::EquilibriumSolver(joint, ligaments, options).solve({{}, {{0, -5, 0}, -0.1}, loads, false});
  ASSERT_EQ(r.status, StepStatus::stable);
  // The root of dE/dtheta = M by bisection, from the energies of single fibres alone.
  const auto moment = [&](double theta) {
    const auto energy = [&](double at) {
      double sum = 0.0;
      for (const model::FibreState& s :
           model::fibre_states(ligaments, {}, {{0, r.pose.translation_mm.y(), 0}, at}))
        sum += s.energy_nmm;
      return sum;
    };
    return (energy(theta + 1e-5) - energy(theta - 1e-5)) / 2e-5;
  };
  double low = 0.0, high = 0.5;
  for (int k = 0; k < 60; ++k)
    (moment(0.5 * (low + high)) < loads.moment_nmm ? low : high) = 0.5 * (low + high);
  EXPECT_NEAR(r.pose.theta_rad, low, 1e-6);
  EXPECT_GT(low, 0.01);
  EXPECT_TRUE(r.theta_determined);
}

TEST(EquilibriumLoads, StartsNearbyEndAtTheSamePose)
{
  const test::MinimalKnee knee;
  const StepRecord stable = knee.solve({{0, -5, 0}, 0}, 0.0);
  ASSERT_EQ(stable.status, StepStatus::stable);
  EXPECT_TRUE(stable.theta_determined);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 30; ++k) {
    MovingPose seed = stable.pose;
    seed.translation_mm += 2.0 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    seed.theta_rad += rad_from_deg(3 * unit(random));
    const StepRecord r = knee.solve(seed, stable.varus_rad + rad_from_deg(3 * unit(random)));
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_LT((r.pose.translation_mm - stable.pose.translation_mm).norm(), 1e-3);
    EXPECT_LT(std::abs(r.pose.theta_rad - stable.pose.theta_rad) * 40, 1e-3);
    EXPECT_LT(std::abs(r.varus_rad - stable.varus_rad) * 40, 1e-3);
  }
}

// Forces and moments about the origin of S on the moving object, from the record and the fibres only.
struct Wrench {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_nmm = Eigen::Vector3d::Zero();
  void add(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& f)
  {
    force_n += f;
    moment_nmm += at_mm.cross(f);
  }
};

Wrench wrench(const model::Ligaments& ligaments, const Attitude& attitude, const StepRecord& r,
              const Loads& loads)
{
  Wrench sum;
  sum.force_n = loads.force_n;
  sum.moment_nmm = loads.point_mm.cross(loads.force_n) + Eigen::Vector3d(0, loads.moment_nmm, 0);
  for (const ContactForce& f : r.balance.forces) sum.add(f.point_solver_mm, test::force_of(f));
  const std::vector<model::FibreState> states = model::fibre_states(ligaments, attitude, r.pose);
  const Eigen::Matrix3d R = reference_rotation(attitude);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const Eigen::Vector3d from = R * ligaments.fibres[k].reference_mm;
    const Eigen::Vector3d to = pose_of(r.pose) * ligaments.fibres[k].moving_mm;
    sum.add(to, states[k].force_n * (from - to).normalized());
  }
  return sum;
}

TEST(EquilibriumLoads, ForcesAndMomentsBalanceOfTheRecordAlone)
{
  const test::MinimalKnee knee;
  Loads loads;
  loads.force_n = {1.5, 40, -1};
  loads.moment_nmm = 60;
  for (const bool is_varus_free : {true, false}) {
    const solve::EquilibriumSolver::Task task{{0.1, 0.02}, {{0.5, -5, 0}, 0.02}, loads, is_varus_free};
    const StepRecord r = solve::EquilibriumSolver(knee.joint, knee.ligaments, options).solve(task);
    ASSERT_EQ(r.status, StepStatus::stable);
    ASSERT_FALSE(r.balance.forces.empty());
    const Wrench sum = wrench(knee.ligaments, {0.1, r.varus_rad}, r, loads);
    // Free coordinates: the certificate's residual (forces, and moments over a lever of 21 mm). Held
    // coordinates: the holding moments.
    const double allowed_n = r.balance.residual_n + 1e-6;
    EXPECT_LT(sum.force_n.norm(), allowed_n);
    // Moments about Delta are about the object's own axis, where dead loads have no moment arm.
    const Eigen::Vector3d at = r.pose.translation_mm;
    EXPECT_NEAR(sum.moment_nmm.y() - (at.z() * loads.force_n.x() - at.x() * loads.force_n.z()) * -1.0, 0.0,
                30 * allowed_n);
    EXPECT_NEAR(sum.moment_nmm.x(), -r.balance.varus_moment_nmm, 30 * allowed_n);
    const Eigen::Vector3d axis = rotation_x(-r.varus_rad) * Eigen::Vector3d::UnitZ();
    // A flexing holding moment acts on the moving object about -axis.
    EXPECT_NEAR(axis.dot(sum.moment_nmm), r.balance.flexion_moment_nmm, 30 * allowed_n + 1e-4);
    EXPECT_LE(r.balance.residual_n, 1e-2 * loads.force_n.norm());
    EXPECT_EQ(r.balance.varus_moment_nmm == 0.0, is_varus_free);
  }
}

}  // namespace vrda::equilibrium_loads_test
