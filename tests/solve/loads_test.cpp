// Applied loads and lines of constant tension, alone and in the equilibrium.
// The equilibrium with ligaments and loads, with and without contact.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "solve/pins.hpp"
#include "solve/potential.hpp"

namespace vrda::loads_test {

using test::ceiling;
using test::joint_of;
using test::pins;

constexpr BodyIndex all_frames[] = {BodyIndex::world, BodyIndex::reference, BodyIndex::moving};

Eigen::Matrix3d rotation_of(BodyIndex frame, const Attitude& attitude, const MovingPose& pose)
{
  if (frame == BodyIndex::world) return Eigen::Matrix3d::Identity();
  return frame == BodyIndex::reference ? reference_rotation(attitude) : rotation_y(pose.theta_rad);
}

struct At {
  Attitude attitude;
  MovingPose pose;
};

At moved(const At& at, const Vector5d& step)
{
  return {{at.attitude.flexion_rad, at.attitude.varus_rad + step(about_varus)},
          {at.pose.translation_mm + step.head<3>(), at.pose.theta_rad + step(about_y)}};
}

// Generalised force of a force in S on a point of the moving object: its work on displacements of the point
// relative to the reference, by central differences.
Vector5d work_per_step(const At& at, const Eigen::Vector3d& force_n, const Eigen::Vector3d& point_mm)
{
  const Eigen::Vector3d force_reference_n = reference_rotation(at.attitude).transpose() * force_n;
  const auto place = [&](const At& there) -> Eigen::Vector3d {
    return reference_rotation(there.attitude).transpose() * (pose_of(there.pose) * point_mm);
  };
  constexpr double h = 1e-5;
  Vector5d work;
  for (Eigen::Index k = 0; k < n_coordinates; ++k) {
    const Vector5d step = h * Vector5d::Unit(k);
    work(k) = force_reference_n.dot(place(moved(at, step)) - place(moved(at, -step))) / (2 * h);
  }
  return work;
}

class Random {
 public:
  double number() { return unit_(engine_); }
  Eigen::Vector3d vector() { return {number(), number(), number()}; }
  At at() { return {{number(), 0.4 * number()}, {10 * vector(), number()}}; }

 private:
  std::mt19937_64 engine_{5};
  std::uniform_real_distribution<double> unit_{-1, 1};
};

Potential near(const Loads& loads, const At& of, const At& at)
{
  return solve::energy_of(solve::potential_near(loads, of.attitude, of.pose), at.attitude, at.pose);
}

// Central differences of moments up to 1e4 N mm.
constexpr double difference_nmm = 1e-4;

TEST(AppliedLoads, AForceDoesItsWorkInEveryFrame)
{
  Random random;
  for (int k = 0; k < 20; ++k) {
    for (const BodyIndex frame : all_frames) {
      const At at = random.at();
      Loads loads;
      loads.applied = {{frame, 50 * random.vector(), {0, 0, 0}, 30 * random.vector()}};
      const AppliedLoad& load = loads.applied[0];
      const Eigen::Vector3d force_n = rotation_of(frame, at.attitude, at.pose) * load.force_n;
      EXPECT_LT((near(loads, at, at).gradient + work_per_step(at, force_n, load.point_mm)).norm(),
                difference_nmm);
      const solve::Wrench wrench = solve::wrench_of(loads, at.attitude, at.pose);
      EXPECT_LT((wrench.force_n - force_n).norm(), 1e-12);
      EXPECT_LT((wrench.moment_nmm - (pose_of(at.pose) * load.point_mm).cross(force_n)).norm(), 1e-9);
    }
  }
}

// Forces f and -f at two points of the moving object are the moment of their couple.
TEST(AppliedLoads, AMomentIsThatOfACouple)
{
  Random random;
  for (int k = 0; k < 20; ++k) {
    for (const BodyIndex frame : all_frames) {
      const At at = random.at();
      const Eigen::Matrix3d R = rotation_of(frame, at.attitude, at.pose);
      const Eigen::Vector3d force_n = 20 * random.vector(), a = 30 * random.vector(),
                            b = 30 * random.vector();
      Loads couple, moment;
      couple.applied = {{frame, force_n, {0, 0, 0}, a}, {frame, -force_n, {0, 0, 0}, b}};
      const Eigen::Vector3d arm_mm = R.transpose() * (rotation_y(at.pose.theta_rad) * (a - b));
      moment.applied = {{frame, {0, 0, 0}, arm_mm.cross(force_n), {0, 0, 0}}};
      EXPECT_LT((near(couple, at, at).gradient - near(moment, at, at).gradient).norm(), 1e-9);
    }
  }
}

TEST(AppliedLoads, ALinePullsItsPointsTogether)
{
  Random random;
  for (int k = 0; k < 20; ++k) {
    const At at = random.at();
    Loads loads;
    loads.lines = {{40, 30 * random.vector(), 30 * random.vector() - Eigen::Vector3d(0, 80, 0)}};
    const TensionLine& line = loads.lines[0];
    const Eigen::Vector3d span_mm =
        reference_rotation(at.attitude) * line.reference_mm - pose_of(at.pose) * line.moving_mm;
    const Potential u = near(loads, at, at);
    EXPECT_NEAR(u.energy_nmm, 40 * span_mm.norm(), 1e-9);
    EXPECT_LT((u.gradient + work_per_step(at, 40 * span_mm.normalized(), line.moving_mm)).norm(),
              difference_nmm);
    EXPECT_LT((solve::wrench_of(loads, at.attitude, at.pose).force_n - 40 * span_mm.normalized()).norm(),
              1e-10);
  }
}

TEST(AppliedLoads, DerivativesMatchDifferences)
{
  Random random;
  for (int k = 0; k < 20; ++k) {
    Loads loads;
    for (const BodyIndex frame : all_frames)
      loads.applied.push_back({frame, 30 * random.vector(), 100 * random.vector(), 20 * random.vector()});
    loads.lines = {{25, 20 * random.vector(), 20 * random.vector() - Eigen::Vector3d(0, 60, 0)}};
    const At of = random.at(), at = moved(of, 0.2 * Vector5d::Ones());
    const Potential u = near(loads, of, at);
    constexpr double h = 1e-5;
    for (Eigen::Index i = 0; i < n_coordinates; ++i) {
      const Vector5d step = h * Vector5d::Unit(i);
      const Potential above = near(loads, of, moved(at, step)), below = near(loads, of, moved(at, -step));
      EXPECT_NEAR((above.energy_nmm - below.energy_nmm) / (2 * h), u.gradient(i), difference_nmm);
      EXPECT_LT((Vector5d((above.gradient - below.gradient) / (2 * h)) - u.hessian.col(i)).norm(),
                difference_nmm);
    }
    EXPECT_EQ(u.hessian, Matrix5d(u.hessian.transpose()));
  }
}

// Forces fixed in the reference have the same potential wherever it is evaluated; at constant varus those
// fixed in the world do too.
TEST(AppliedLoads, AForceFixedInTheReferenceIsExactEverywhere)
{
  Random random;
  for (const bool is_world : {false, true}) {
    Loads loads;
    loads.applied = {
        {is_world ? BodyIndex::world : BodyIndex::reference, {10, 20, -5}, {0, 0, 0}, {3, -9, 7}}};
    const At of = random.at();
    At at = random.at();
    at.attitude.flexion_rad = of.attitude.flexion_rad;
    if (is_world) at.attitude.varus_rad = of.attitude.varus_rad;
    EXPECT_LT((near(loads, of, at).gradient - near(loads, at, at).gradient).norm(), 1e-10);
    EXPECT_NEAR(near(loads, of, at).energy_nmm, near(loads, at, at).energy_nmm, 1e-10);
  }
}

const EquilibriumOptions options;
constexpr double standoff_mm = 1e-5;
// Stiffness of the proximal term that keeps a pose near its seed, of the push per mm (solve/README.md).
constexpr double proximal_per_mm = 1e-6;

StepRecord solved(const solve::Joint& joint, const MovingPose& seed, const Loads& loads)
{
  const model::Ligaments none;
  return solve::EquilibriumSolver(joint, none, options).solve({{}, seed, loads, false});
}

// A pin pushed up against a slope and pulled down by a line of known tension: along the slope the line's
// component balances the push, so its angle from the normal is known.
TEST(LoadedEquilibrium, ALineHoldsAPinOnASlope)
{
  const double slope = 0.3, push_n = 20, depth_mm = 40;
  const solve::Joint joint =
      joint_of(ceiling(80, 16, [&](double x, double) { return slope * x; }), pins({{0, 0, 0}}));
  const double secant = std::sqrt(1 + slope * slope);
  for (const double tension_n : {8.0, 10.0, 18.0}) {
    SCOPED_TRACE(tension_n);
    Loads loads;
    loads.force_n = {0, push_n, 0};
    loads.lines = {{tension_n, {0, -depth_mm, 0}, {0, 0, 0}}};
    const MovingPose seed{{-5, -20, 4}, 0.1};
    const StepRecord r = solved(joint, seed, loads);
    ASSERT_EQ(r.status, StepStatus::stable);
    const double distance_mm = depth_mm / secant;  // from the line's origin to the slope
    const double sine = push_n * slope / secant / tension_n, cosine = std::sqrt(1 - sine * sine);
    const double along_mm = distance_mm * sine / cosine;
    const Eigen::Vector3d tip(-distance_mm * slope / secant + along_mm / secant,
                              -depth_mm + distance_mm / secant + along_mm * slope / secant - standoff_mm, 0);
    const double stiffness_n_mm = tension_n * cosine * cosine * cosine / distance_mm;
    const double proximal_n = proximal_per_mm * push_n * (tip - seed.translation_mm).norm();
    EXPECT_LT((r.pose.translation_mm - tip).norm(), options.tolerance_mm + proximal_n / stiffness_n_mm);
    ASSERT_EQ(r.balance.forces.size(), 1U);
    EXPECT_NEAR(test::force_of(r.balance.forces[0]).norm(), push_n / secant - tension_n * cosine, 1e-3);
    EXPECT_LT(r.balance.residual_n, 1e-3);
  }
}

// A pin in a pit turns under a force at an arm against four lines of constant tension. The force's moment
// about Delta is constant if it turns with the object, otherwise it falls with the cosine.
TEST(LoadedEquilibrium, AForceTurnsWithTheObjectOrDoesNot)
{
  constexpr double arm_mm = 15, force_n = 30, tension_n = 20, x_mm = 20, z_mm = 30;
  const auto pit = [](double x, double z) { return -0.5 * (std::abs(x) + std::abs(z)); };
  const solve::Joint joint =
      joint_of(ceiling(80, 16, pit), pins({{0, 0, 0}, {x_mm, -15, 0}, {-x_mm, -15, 0}}));
  for (const BodyIndex frame : all_frames) {
    SCOPED_TRACE(name_of(frame));
    Loads loads;
    loads.force_n = {0, 200, 0};
    for (const double x : {x_mm, -x_mm}) {
      for (const double z : {z_mm, -z_mm}) loads.lines.push_back({tension_n, {x, -10, z}, {x, -10, 0}});
    }
    loads.applied = {{frame, {force_n, 0, 0}, {0, 0, 0}, {0, 0, arm_mm}}};
    const MovingPose seed{{0, -5, 0}, 0.1};
    const StepRecord r = solved(joint, seed, loads);
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_LT((r.pose.translation_mm - Eigen::Vector3d(0, -standoff_mm, 0)).norm(), 1e-6);
    const auto unbalanced_nmm = [&](double theta) {
      const double s = std::sin(theta), c = std::cos(theta);
      double lines_nmm = 0.0;
      for (const double z : {z_mm, -z_mm}) {
        // The moving end at (x c, -x s); twice, for both signs of x.
        const double across = x_mm - x_mm * c, along = z + x_mm * s;
        const double length = std::sqrt(across * across + along * along);
        lines_nmm += 2 * tension_n * (across * x_mm * s + along * x_mm * c) / length;
      }
      return arm_mm * force_n * (frame == BodyIndex::moving ? 1.0 : c) - lines_nmm;
    };
    EXPECT_GT(r.pose.theta_rad, 0.3);
    const double lever_mm = x_mm + 1;  // half the pins' extent
    const double proximal_nmm =
        proximal_per_mm * loads.force_n.norm() * lever_mm * lever_mm * (r.pose.theta_rad - seed.theta_rad);
    EXPECT_NEAR(unbalanced_nmm(r.pose.theta_rad), 0.0, proximal_nmm + 1e-3);
    Eigen::Vector3d sum_n = loads.force_n + solve::wrench_of(loads, {}, r.pose).force_n;
    for (const ContactForce& f : r.balance.forces) sum_n += test::force_of(f);
    EXPECT_LT(sum_n.norm(), 1e-2);
  }
}

Loads loads_of_every_kind()
{
  Loads loads;
  loads.force_n = {1, 40, -1};
  loads.applied = {{BodyIndex::moving, {3, 2, -2}, {10, 60, 20}, {5, -20, 8}},
                   {BodyIndex::reference, {-2, 3, 1}, {0, 20, -10}, {-6, -3, 10}},
                   {BodyIndex::world, {1, 4, 2}, {-20, 0, 30}, {2, -30, -12}}};
  loads.lines = {{15, {4, 30, 10}, {10, -30, 5}}, {8, {-15, 20, -20}, {-4, -25, -18}}};
  return loads;
}

// Forces and moments of the record with the loads in their final directions, summed independently.
TEST(LoadedEquilibrium, TheRecordBalancesTheLoadsInTheirFinalDirections)
{
  const test::MinimalKnee knee;
  const Loads loads = loads_of_every_kind();
  for (const bool is_varus_free : {true, false}) {
    SCOPED_TRACE(is_varus_free);
    const solve::EquilibriumSolver::Task task{{0.1, 0.02}, {{0.5, -5, 0}, 0.02}, loads, is_varus_free};
    const StepRecord r = solve::EquilibriumSolver(knee.joint, knee.ligaments, options).solve(task);
    ASSERT_EQ(r.status, StepStatus::stable);
    ASSERT_FALSE(r.balance.forces.empty());
    const Attitude attitude{0.1, r.varus_rad};
    Eigen::Vector3d force_n = loads.force_n, moment_nmm = Eigen::Vector3d::Zero();
    const auto add = [&](const Eigen::Vector3d& at_mm, const Eigen::Vector3d& f) {
      force_n += f;
      moment_nmm += at_mm.cross(f);
    };
    for (const AppliedLoad& load : loads.applied) {
      const Eigen::Matrix3d R = rotation_of(load.frame, attitude, r.pose);
      add(pose_of(r.pose) * load.point_mm, R * load.force_n);
      moment_nmm += R * load.moment_nmm;
    }
    const Eigen::Matrix3d R = reference_rotation(attitude);
    const auto pull = [&](const Eigen::Vector3d& reference_mm, const Eigen::Vector3d& moving_mm, double n) {
      const Eigen::Vector3d to = pose_of(r.pose) * moving_mm;
      add(to, n * (R * reference_mm - to).normalized());
    };
    for (const TensionLine& line : loads.lines) pull(line.reference_mm, line.moving_mm, line.tension_n);
    const std::vector<model::FibreState> states = model::fibre_states(knee.ligaments, attitude, r.pose);
    for (std::size_t k = 0; k < states.size(); ++k)
      pull(knee.ligaments.fibres[k].reference_mm, knee.ligaments.fibres[k].moving_mm, states[k].force_n);
    for (const ContactForce& f : r.balance.forces) add(f.point_solver_mm, test::force_of(f));
    const double allowed_n = r.balance.residual_n + 1e-4, lever_mm = 30;
    EXPECT_LT(force_n.norm(), allowed_n);
    // The push has no moment about the object's own axis.
    const Eigen::Vector3d arm_nmm = r.pose.translation_mm.cross(force_n - loads.force_n);
    EXPECT_NEAR((moment_nmm - arm_nmm).y(), 0.0, lever_mm * allowed_n);
    EXPECT_NEAR(moment_nmm.x(), -r.balance.varus_moment_nmm, lever_mm * allowed_n);
    const Eigen::Vector3d axis = rotation_x(-r.varus_rad) * Eigen::Vector3d::UnitZ();
    EXPECT_NEAR(axis.dot(moment_nmm), r.balance.flexion_moment_nmm, lever_mm * allowed_n);
    EXPECT_EQ(r.balance.varus_moment_nmm == 0.0, is_varus_free);
    EXPECT_LE(r.balance.residual_n, 1e-2 * loads.force_n.norm());
  }
}

// 30 N against the 20 N of the push.
TEST(LoadedEquilibrium, ALoadThatPullsOffTheReferenceIsUnbounded)
{
  const solve::Joint joint = joint_of(ceiling(60, 4, [](double, double) { return 0.0; }), pins({{0, 0, 0}}));
  Loads loads;
  loads.applied = {{BodyIndex::moving, {0, -30, 0}, {0, 0, 0}, {0, 0, 0}}};
  EXPECT_EQ(solved(joint, {{0, -5, 0}, 0}, loads).status, StepStatus::unbounded);
}

constexpr double k_n = test::fibre_stiffness_n;  // of every fibre, per unit strain
constexpr double transition = 0.06;

using test::fibre;

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

}  // namespace vrda::loads_test
