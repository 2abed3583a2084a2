// The equilibrium with contact and without ligaments.
// The certificate of the equilibrium: compressive contact forces, compared with an independent solution.
// Compares the equilibrium with NLopt's subplex, which uses only the potential of a configuration in
// equilibrium along Delta: no features, gradients or active sets.
#include <gtest/gtest.h>
#include <nlopt.h>
#include <Eigen/Dense>

#include <cmath>
#include <exception>
#include <random>

#include "core/units.hpp"
#include "geometry/shapes.hpp"
#include "solve/equilibrium.hpp"
#include "solve/pins.hpp"
#include "solve/potential.hpp"
#include "solve/stability_search.hpp"

namespace vrda::equilibrium_test {

const EquilibriumOptions options;
// Travel left in the end: a tenth of the tolerance.
constexpr double standoff_mm = 1e-5;
// Tolerance of poses determined by flat faces: a hundredth of the solver's tolerance.
constexpr double exact_mm = 1e-6;

using test::ceiling;
using test::joint_of;
using test::pins;

StepRecord solve(const solve::Joint& joint, const MovingPose& seed, const Loads& loads = {},
                 bool is_varus_free = false)
{
  const model::Ligaments none;
  return solve::EquilibriumSolver(joint, none, options).solve({{}, seed, loads, is_varus_free});
}

double pit(double x, double z)
{
  return -0.5 * (std::abs(x) + std::abs(z));
}

MovingPose random_seed(std::mt19937_64& random, double reach_mm)
{
  std::uniform_real_distribution<double> unit(-1, 1);
  return {{reach_mm * unit(random), -30 + 60 * unit(random), reach_mm * unit(random)}, unit(random)};
}

TEST(Equilibrium, APinEndsInTheMiddleOfItsPit)
{
  const solve::Joint joint = joint_of(ceiling(60, 12, pit), pins({{0, 0, 0}}));
  std::mt19937_64 random(1);
  for (int k = 0; k < 40; ++k) {
    const MovingPose seed = random_seed(random, 20);
    const StepRecord r = solve(joint, seed);
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_NEAR((r.pose.translation_mm - Eigen::Vector3d(0, -standoff_mm, 0)).norm(), 0.0, exact_mm);
    EXPECT_FALSE(r.theta_determined);
    // No moment about Delta.
    EXPECT_NEAR(r.pose.theta_rad, seed.theta_rad, 1e-6);
    EXPECT_LT(r.balance.residual_n, 1e-6);
    EXPECT_NEAR(r.balance.worst_gap_mm, standoff_mm, 1e-9);
    EXPECT_LE(r.iterations, 20);
  }
}

TEST(Equilibrium, ABallEndsInTheMiddleOfItsDish)
{
  const geometry::Shape shape = geometry::generate_shape({"ball-in-dish", {}, {}});
  const solve::Joint joint =
      solve::make_joint({shape.reference.front().mesh, {}}, {shape.moving.front().mesh, {}}, {});
  const double radius_mm = 10, dish_mm = 30;
  const Box box = bounding_box(shape.moving.front().mesh);
  const Eigen::Vector3d top_mm(0, box.max_mm.y(), 0);
  // Facets deviate from ball and dish by their sagitta: edges of 1.4 mm and 0.75 mm sqrt(2).
  const double sagitta_mm = 1.4 * 1.4 / (4 * radius_mm) + 1.1 * 1.1 / (4 * dish_mm);
  // Error of the middle for that height, by the gap's curvature: r^2 / 2 (1 / R_dish... ).
  const double off_mm = std::sqrt(2 * sagitta_mm * (dish_mm - radius_mm));
  std::mt19937_64 random(2);
  for (int k = 0; k < 20; ++k) {
    const StepRecord r = solve(joint, random_seed(random, 6));
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_NEAR(r.pose.translation_mm.y() + top_mm.y(), 0.0, sagitta_mm);
    EXPECT_LT(std::hypot(r.pose.translation_mm.x(), r.pose.translation_mm.z()), off_mm);
    EXPECT_FALSE(r.contacts.empty());
  }
}

TEST(Equilibrium, ABallUnderAPlateRestsWhereItWasSeeded)
{
  const solve::Joint joint =
      solve::make_joint({test::box({0, 10, 0}, {100, 20, 100}), {}}, {test::ball(10), {}}, {});
  const StepRecord r = solve(joint, {{3, -40, 4}, 0.3});
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR((r.pose.translation_mm - Eigen::Vector3d(3, -10 - standoff_mm, 4)).norm(), 0.0, exact_mm);
  EXPECT_EQ(r.pose.theta_rad, 0.3);
  EXPECT_FALSE(r.theta_determined);
}

Mesh soft(Mesh mesh, double overlap_mm)
{
  mesh.overlap_mm.assign(static_cast<std::size_t>(mesh.triangles.rows()), overlap_mm);
  return mesh;
}

StepRecord under_a_plate(const Mesh& plate, const Mesh& ball)
{
  const solve::Joint joint = solve::make_joint({inward_limit(plate), {}}, {inward_limit(ball), {}}, {});
  return solve(joint, {{3, -40, 4}, 0.3});
}

// The first contact of the ball is its pole, whose facets are half a ring off the axis.
TEST(Equilibrium, ASoftPlateLetsTheBallInByItsOverlap)
{
  const Mesh hard = test::box({0, 10, 0}, {100, 20, 100});
  const double pole_mm = std::hypot(1.0, std::tan(pi / 32) / std::cos(pi / 32));
  struct Row {
    Mesh plate, ball;
    double deeper_mm;
  };
  Mesh with_bone = soft(hard, 1.0);
  append(with_bone, test::box({0, 10.4, 0}, {100, 20, 100}));
  for (const Row& row :
       {Row{soft(hard, 1.0), test::ball(10), 1.0}, Row{hard, soft(test::ball(10), 1.0), pole_mm},
        Row{soft(hard, 1.0), soft(test::ball(10), 1.0), 1.0 + pole_mm},
        Row{with_bone, test::ball(10), 0.4}}) {
    SCOPED_TRACE(row.deeper_mm);
    const StepRecord r = under_a_plate(row.plate, row.ball);
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_NEAR(r.pose.translation_mm.y(), -10 - standoff_mm + row.deeper_mm, exact_mm);
    EXPECT_NEAR(r.balance.worst_gap_mm, standoff_mm, exact_mm) << "from the allowed overlap";
    ASSERT_EQ(r.contacts.size(), 1u);
  }
  // The true distance, at the plate's surface.
  const ContactRecord contact = under_a_plate(soft(hard, 1.0), test::ball(10)).contacts.front();
  EXPECT_NEAR(contact.distance_mm, -1.0 + standoff_mm, exact_mm);
  EXPECT_NEAR((contact.point_solver_mm - Eigen::Vector3d(3, 0, 4)).norm(), 0.0, exact_mm);
}

// A sheet thinner than twice its overlap: the limit of its far side is in front of that of its near side.
TEST(Equilibrium, AThinSoftPartTouchesWithItsNearSide)
{
  const StepRecord r = under_a_plate(soft(test::box({0, 0.5, 0}, {100, 1, 100}), 0.8), test::ball(10));
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR(r.pose.translation_mm.y(), -10 - standoff_mm + 0.8, exact_mm);
  ASSERT_EQ(r.contacts.size(), 1u);
  EXPECT_NEAR(r.contacts.front().distance_mm, -0.8 + standoff_mm, exact_mm);
}

TEST(Equilibrium, AGrooveTurnsUntilBothSpikesLieInIt)
{
  // Spikes of the reference at (10, 0, 1) and (-10, 0, -1), a groove along X below: it rotates by -atan(0.1)
  // and does not move along itself.
  Mesh spikes = test::box({0, 10, 0}, {30, 2, 10});
  for (const double side : {1.0, -1.0}) {
    Mesh spike = test::pin({0, 0, 0});
    spike.vertices_mm.col(1) *= -1;
    spike.triangles.col(1).swap(spike.triangles.col(2));
    spike.vertices_mm.rowwise() += Eigen::RowVector3d(10 * side, 0, side);
    append(spikes, spike);
  }
  Mesh groove = ceiling(40, 2, [](double, double z) { return 0.3 * std::abs(z); });
  groove.triangles.col(1).swap(groove.triangles.col(2));
  const solve::Joint joint = solve::make_joint({spikes, {}}, {groove, {}}, {});
  for (const double theta : {0.0, 0.2, -0.3}) {
    const StepRecord r = solve(joint, {{0.5, -20, 0.2}, theta});
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_NEAR(r.pose.theta_rad, -std::atan(0.1), exact_mm / 10);
    EXPECT_NEAR(r.pose.translation_mm.y(), -standoff_mm, exact_mm);
    EXPECT_TRUE(r.theta_determined);
    EXPECT_EQ(r.contacts.size(), 2u);
  }
}

TEST(Equilibrium, ACapTurnsIntoItsSink)
{
  for (const double turn_deg : {5.0, 20.0, -12.0}) {
    const geometry::Shape shape = geometry::generate_shape(
        {"cap-in-sink", {{"turn", turn_deg}, {"offset_x", 1.0}, {"offset_z", -0.5}}, {}});
    const solve::Joint joint =
        solve::make_joint({shape.reference.front().mesh, {}}, {shape.moving.front().mesh, {}}, {});
    const StepRecord r = solve(joint, {});
    ASSERT_EQ(r.status, StepStatus::stable);
    // Edges parallel to edges: rounding of the rotated mesh over its size, and the tolerance.
    EXPECT_NEAR(deg_from_rad(r.pose.theta_rad), -turn_deg, 1e-3);
    EXPECT_TRUE(r.theta_determined);
  }
}

// Two troughs along X at z = +-20: the moving object's pins fit if their tips are 40 mm apart.
Mesh troughs()
{
  return ceiling(80, 8, [](double, double z) { return -0.3 * std::abs(std::abs(z) - 20); });
}

TEST(Equilibrium, FreeVarusTurnsUntilBothSidesTouch)
{
  for (const double tilt : {-0.1, 0.0, 0.05}) {
    const double y = 20 * std::sin(tilt), z = 20 * std::cos(tilt);
    const solve::Joint joint = joint_of(troughs(), pins({{0, y, z}, {0, -y, -z}}));
    const StepRecord r = solve(joint, {{1, -25, 0.4}, 0.02}, {}, true);
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_NEAR(r.varus_rad, tilt, exact_mm);
    EXPECT_NEAR(r.pose.translation_mm.y(), 0.0, 2 * standoff_mm);
    EXPECT_TRUE(r.is_in_contact[0] && r.is_in_contact[1]);
    EXPECT_EQ(r.balance.varus_moment_nmm, 0.0);
  }
}

TEST(Equilibrium, ThePushPointSharesTheLoadByTheLeverRule)
{
  const solve::Joint joint = joint_of(troughs(), pins({{0, 0, 20}, {0, 0, -20}}));
  for (const double at_mm : {-15.0, 0.0, 5.0, 19.0}) {
    Loads loads;
    loads.point_mm = {0, 0, at_mm};
    const StepRecord r = solve(joint, {{0, -25, 0.3}, 0.01}, loads, true);
    ASSERT_EQ(r.status, StepStatus::stable);
    double medial_n = 0.0, lateral_n = 0.0;
    for (const ContactForce& f : r.balance.forces)
      (f.compartment == static_cast<std::int8_t>(Compartment::medial) ? medial_n : lateral_n) +=
          f.along_delta_n;
    EXPECT_NEAR(lateral_n, 20 * (20 + at_mm) / 40, 1e-4);
    EXPECT_NEAR(medial_n, 20 * (20 - at_mm) / 40, 1e-4);
  }
}

TEST(Equilibrium, AHeldVarusIsHeldByAMoment)
{
  // One pin at z = 20 carries all the push; the holding moment prevents tipping.
  const solve::Joint joint = joint_of(troughs(), pins({{0, 0, 20}, {0, -3, -20}}));
  const StepRecord r = solve(joint, {{0, -25, 0.3}, 0.01});
  ASSERT_EQ(r.status, StepStatus::stable);
  // Varus lowers the reference on that side by 20 mm per radian: the moment is F times that.
  EXPECT_NEAR(r.balance.varus_moment_nmm, -20 * 20.0, 0.01);
  ASSERT_EQ(r.balance.forces.size(), 2u);  // both flanks
  // The contact pushes down in front of the axis or behind it; the flexion moment balances it.
  EXPECT_NEAR(r.balance.flexion_moment_nmm, -20 * r.balance.forces[0].point_solver_mm.x(), 1e-3);
  EXPECT_TRUE(r.is_in_contact[1]);
  EXPECT_FALSE(r.is_in_contact[0]);
  EXPECT_NEAR(r.gap_mm[0], 3.0, 1e-3);
}

TEST(Equilibrium, FlanksShareALateralForceUntilItSlidesOut)
{
  const double slope = 0.3;
  const solve::Joint joint =
      joint_of(ceiling(60, 12, [&](double x, double) { return -slope * std::abs(x); }), pins({{0, 0, 0}}));
  for (const double sideways_n : {0.0, 2.0, -5.5}) {
    Loads loads;
    loads.force_n.x() = sideways_n;
    const StepRecord r = solve(joint, {{4, -20, 1}, 0}, loads);
    ASSERT_EQ(r.status, StepStatus::stable);
    EXPECT_NEAR(r.pose.translation_mm.x(), 0.0, exact_mm);
    Eigen::Vector3d sum = loads.force_n;
    for (const ContactForce& f : r.balance.forces) {
      sum += test::force_of(f);
      EXPECT_NEAR(std::abs(f.normal_solver.x() / f.normal_solver.y()), slope, 1e-9);
      const double share_n = 0.5 * (20 + (f.normal_solver.x() < 0.0 ? 1 : -1) * sideways_n / slope);
      EXPECT_NEAR(f.along_delta_n, share_n, 1e-4);
    }
    EXPECT_LT(sum.norm(), 1e-4);
  }
  Loads loads;
  loads.force_n.x() = 6.5;
  EXPECT_EQ(solve(joint, {{4, -20, 1}, 0}, loads).status, StepStatus::unbounded);
}

TEST(Equilibrium, EveryOtherStatusOccurs)
{
  const solve::Joint joint = joint_of(ceiling(60, 12, pit), pins({{0, 0, 0}}));
  EXPECT_EQ(solve(joint, {{100, 0, 0}, 0}).status, StepStatus::no_contact);
  const model::Ligaments none;
  EquilibriumOptions short_of;
  short_of.max_iterations = 1;
  const StepRecord cut =
      solve::EquilibriumSolver(joint, none, short_of).solve({{}, {{15, 0, 9}, 0}, {}, false});
  EXPECT_EQ(cut.status, StepStatus::iteration_limit);
  EXPECT_EQ(cut.iterations, 1);
  EXPECT_TRUE(cut.contacts.empty());
  EXPECT_TRUE(std::isnan(cut.balance.residual_n));
  const solve::Joint slope =
      joint_of(ceiling(60, 12, [](double x, double) { return 0.3 * x; }), pins({{0, 0, 0}}));
  EXPECT_EQ(solve(slope, {{0, 0, 0}, 0}).status, StepStatus::unbounded);
  Loads pull;
  pull.force_n = {0, -20, 0};
  EXPECT_EQ(solve(joint, {{0, 0, 0}, 0}, pull).status, StepStatus::unbounded);
}

bool is_same(const StepRecord& a, const StepRecord& b)
{
  return a.status == b.status && a.pose.translation_mm == b.pose.translation_mm &&
         a.pose.theta_rad == b.pose.theta_rad && a.varus_rad == b.varus_rad && a.iterations == b.iterations &&
         a.queries == b.queries && std::isnan(a.balance.residual_n) == std::isnan(b.balance.residual_n) &&
         a.balance.forces.size() == b.balance.forces.size() && a.contacts.size() == b.contacts.size() &&
         a.theta_determined == b.theta_determined &&
         (a.balance.energy_nmm == b.balance.energy_nmm || std::isnan(a.balance.energy_nmm)) &&
         a.residual_mm == b.residual_mm;
}

TEST(Equilibrium, WhatWasSolvedBeforeChangesNoBit)
{
  const geometry::Shape shape = geometry::generate_shape({"ball-in-dish", {}, {}});
  const solve::Joint joint =
      solve::make_joint({shape.reference.front().mesh, {}}, {shape.moving.front().mesh, {}}, {});
  const model::Ligaments none;
  solve::EquilibriumSolver one(joint, none, options);
  const solve::EquilibriumSolver::Task a{{0.1, 0.02}, {{4, 0, 3}, 0.2}, {}, false};
  const solve::EquilibriumSolver::Task b{{-0.1, 0.1}, {{-5, 0, 1}, 0}, {}, true};
  const StepRecord first = one.solve(a);
  const StepRecord between = one.solve(b);
  EXPECT_EQ(first.status, StepStatus::stable);
  EXPECT_TRUE(is_same(one.solve(a), first));
  EXPECT_TRUE(is_same(solve::EquilibriumSolver(joint, none, options).solve(a), first));
  EXPECT_TRUE(is_same(solve::EquilibriumSolver(joint, none, options).solve(b), between));
}

// The search maximises the same height: the equilibrium is not lower by more than the search's resolution.
TEST(Equilibrium, AStepThatEntersAKnownEquilibriumReturnsItsRecord)
{
  const solve::Joint joint = joint_of(ceiling(60, 12, pit), pins({{-2, 0, 0}, {3, 0, 1}}));
  const model::Ligaments none;
  solve::EquilibriumSolver solver(joint, none, options);
  solve::EquilibriumSolver::Task task{{}, {{4, -30, 3}, 0.4}, {}};
  const StepRecord alone = solver.solve(task);
  ASSERT_EQ(alone.status, StepStatus::stable);
  // The same within the tolerance, but not to the last bit.
  StepRecord same = alone;
  same.pose.translation_mm.x() += 1e-6;
  StepRecord higher = same, elsewhere = same, unsolved = same;
  higher.balance.energy_nmm += 0.1;
  elsewhere.pose.translation_mm.x() += 0.5;
  unsolved.status = StepStatus::iteration_limit;
  std::vector<StepRecord> known{higher, elsewhere, unsolved};
  task.known = &known;
  const StepRecord own = solver.solve(task);
  EXPECT_EQ(own.pose.translation_mm, alone.pose.translation_mm);
  EXPECT_EQ(own.queries, alone.queries);
  known.push_back(same);
  const StepRecord entered = solver.solve(task);
  EXPECT_EQ(entered.pose.translation_mm, same.pose.translation_mm);
  EXPECT_EQ(entered.balance.energy_nmm, same.balance.energy_nmm);
  EXPECT_EQ(entered.contacts.size(), same.contacts.size());
  EXPECT_LT(entered.queries, alone.queries);
  EXPECT_LE(entered.iterations, alone.iterations);
}

// The gap of a compartment in contact is that of its gap query, without one.
TEST(Equilibrium, CompartmentsInContactAndOffItReportTheirGaps)
{
  const solve::Joint joint = joint_of(ceiling(60, 12, pit), pins({{0, 0, -2}, {1, 0, 3}}));
  const model::Ligaments none;
  solve::EquilibriumSolver solver(joint, none, options);
  for (const double varus_deg : {0.0, 3.0, -3.0}) {
    const Attitude attitude{0.0, rad_from_deg(varus_deg)};
    const StepRecord r = solver.solve({attitude, {{1, -30, 1}, 0.2}, {}});
    ASSERT_EQ(r.status, StepStatus::stable);
    geometry::GapQuery medial(joint.reference_gap, joint.compartment_gap[0]),
        lateral(joint.reference_gap, joint.compartment_gap[1]);
    medial.set_attitude(attitude);
    lateral.set_attitude(attitude);
    EXPECT_NEAR(r.gap_mm[0], medial.travel_mm(r.pose), 1e-9);
    EXPECT_NEAR(r.gap_mm[1], lateral.travel_mm(r.pose), 1e-9);
    EXPECT_NEAR(std::min(r.gap_mm[0], r.gap_mm[1]), standoff_mm, 1e-9);
  }
}

TEST(Equilibrium, IsAtLeastAsFarAlongDeltaAsTheSearch)
{
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const SearchOptions search;
  int n_higher = 0;
  for (int k = 0; k < 12; ++k) {
    const std::vector<std::string> scenes = {"ball-in-dish", "bar-on-pyramids", "cap-in-sink"};
    const geometry::Shape shape =
        geometry::generate_shape({scenes[static_cast<std::size_t>(k % 3)],
                                  {{"turn", 15 * unit(random)}, {"offset_x", 1.5 * unit(random)}},
                                  {}});
    const solve::Joint joint =
        solve::make_joint({shape.reference.front().mesh, {}}, {shape.moving.front().mesh, {}}, {});
    const StepRecord r = solve(joint, {}), s = solve::find_stable_pose(joint, {}, {}, search);
    ASSERT_EQ(r.status, StepStatus::stable);
    ASSERT_EQ(s.status, StepStatus::stable);
    EXPECT_GE(r.pose.translation_mm.y(), s.pose.translation_mm.y() - search.translation_resolution_mm);
    n_higher += r.pose.translation_mm.y() > s.pose.translation_mm.y() ? 1 : 0;
  }
  EXPECT_GT(n_higher, 6);
}

constexpr std::array<bool, 5> all_free{true, true, true, true, true};
const solve::RotationScale scale{{0, 0, 0}, 20};

// Minimum of |g - A l| over l >= 0 by exhaustive search over the active columns.
double least_residual(const Vector5d& g, const std::vector<solve::Clearance>& touching)
{
  double best = g.norm();
  for (unsigned choice = 1; choice < (1U << touching.size()); ++choice) {
    Eigen::MatrixXd A(5, 0);
    for (std::size_t k = 0; k < touching.size(); ++k) {
      if ((choice >> k & 1U) == 0) continue;
      A.conservativeResize(5, A.cols() + 1);
      A.col(A.cols() - 1) = touching[k].gradient;
    }
    A.bottomRows(2) /= scale.lever_mm;
    const Eigen::VectorXd l = A.colPivHouseholderQr().solve(g);
    if (l.minCoeff() >= 0.0) best = std::min(best, (A * l - g).norm());
  }
  return best;
}

TEST(Balance, IsTheLeastSquaresOfForcesThatPush)
{
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  int n_balanced = 0, n_unbalanced = 0;
  for (int k = 0; k < 300; ++k) {
    Potential u;
    u.gradient << normal(random), -20, normal(random), 20 * normal(random), 20 * normal(random);
    std::vector<solve::Clearance> touching(static_cast<std::size_t>(1 + k % 9));
    for (solve::Clearance& c : touching)
      c.gradient << 0.3 * normal(random), -1, 0.3 * normal(random), 10 * normal(random), 10 * normal(random);
    const solve::ContactForceBalance balance = solve::balance_contact_forces(u, touching, scale, all_free);
    Vector5d g = u.gradient;
    g.tail<2>() /= scale.lever_mm;
    EXPECT_NEAR(balance.residual_n, least_residual(g, touching), 1e-7);
    for (const solve::ContactForceBalance::ActiveConstraint& b : balance.active)
      EXPECT_GT(b.along_delta_n, 0.0);
    ++(balance.residual_n < 1e-9 ? n_balanced : n_unbalanced);
  }
  EXPECT_GT(n_balanced, 5);
  EXPECT_GT(n_unbalanced, 50);
}

TEST(Balance, PoseOffEquilibriumHasResidual)
{
  const solve::Joint joint = test::joint_of(
      test::ceiling(60, 12, [](double x, double z) { return -0.5 * (std::abs(x) + std::abs(z)); }),
      test::pins({{0, 0, 0}}));
  const model::Ligaments none;
  const Loads loads;
  geometry::GapQuery query(joint.reference_gap, joint.moving_gap);
  query.set_attitude({});
  struct Row {
    double x_mm, residual_share;
  };
  // In the middle all four flanks are in the band and balance the push. On one flank the residual is the
  // component of the push perpendicular to the normal (1, -2, 1) / sqrt(6).
  for (const Row row : {Row{0.0, 0.0}, Row{1.0, std::sqrt(1.0 / 3.0)}}) {
    MovingPose pose{{row.x_mm, 0, row.x_mm}, 0};
    pose.translation_mm.y() += query.travel_mm(pose);
    const solve::Configuration configuration = solve::configuration_at(pose, 0.0, scale);
    const solve::Rotations rotations(configuration, 0.0);
    std::vector<solve::Clearance> touching;
    for (const geometry::GapFeature& f : query.features(pose, 1e-3).features) {
      const solve::ContactConstraint constraint = solve::contact_constraint_of(
          f, {joint.reference.tree_mesh.mesh, joint.moving.tree_mesh.mesh, scale}, configuration, rotations);
      touching.push_back(solve::clearance(constraint, configuration, rotations));
    }
    const solve::ContactForceBalance balance =
        solve::balance_contact_forces(solve::potential_at({none, loads, scale, 0.0}, configuration), touching,
                                      scale, {true, true, true, true, false});
    EXPECT_NEAR(balance.residual_n, row.residual_share * 20, 1e-6);
  }
}

constexpr double radius_mm = 1.0;  // about the start
constexpr double lever_mm = 20.0;

struct Landscape {
  const test::MinimalKnee& knee;
  Loads loads;
  solve::RotationScale scale{{0, 0, 0}, lever_mm};
  geometry::GapQuery query{knee.joint.reference_gap, knee.joint.moving_gap};
  solve::Configuration start{};
  std::exception_ptr thrown{};  // exceptions must not propagate through a C callback
  nlopt_opt optimiser = nullptr;

  double potential_nmm(const double* step)
  {
    Vector5d step_mm;
    step_mm << step[0], 0, step[1], step[2], step[3];
    const solve::Configuration configuration = solve::moved(start, step_mm, scale);
    query.set_attitude({0.1, configuration.varus_rad});
    const double travel_mm = query.travel_mm(solve::pose_at(configuration, scale));
    check(std::isfinite(travel_mm), "cross-check: nothing faces");
    const solve::NonContactForces forces{knee.ligaments, loads, scale, 0.1};
    return solve::equilibrium_along_delta(forces, configuration,
                                          {configuration.pivot_mm.y() + travel_mm, 100, 1e-9})
        .potential.energy_nmm;
  }
};

double objective(unsigned, const double* x, double*, void* data)
{
  auto& landscape = *static_cast<Landscape*>(data);
  try {
    return landscape.potential_nmm(x);
  } catch (...) {
    landscape.thrown = std::current_exception();
    nlopt_force_stop(landscape.optimiser);
    return 0.0;
  }
}

// Subplex with restarts from its best point, since kinks stall its simplex.
double least_by_subplex(Landscape& landscape)
{
  double x[4] = {0, 0, 0, 0}, least = 0.0;
  for (int k = 0; k < 12; ++k) {
    landscape.optimiser = nlopt_create(NLOPT_LN_SBPLX, 4);
    nlopt_set_min_objective(landscape.optimiser, objective, &landscape);
    nlopt_set_lower_bounds1(landscape.optimiser, -radius_mm);
    nlopt_set_upper_bounds1(landscape.optimiser, radius_mm);
    nlopt_set_initial_step1(landscape.optimiser, k % 2 == 0 ? 0.3 : 0.03);
    nlopt_set_xtol_abs1(landscape.optimiser, 1e-8);
    nlopt_set_maxeval(landscape.optimiser, 4000);
    nlopt_optimize(landscape.optimiser, x, &least);
    nlopt_destroy(landscape.optimiser);
    if (landscape.thrown) std::rethrow_exception(landscape.thrown);
  }
  return least;
}

TEST(CrossCheck, SubplexFindsNoLowerPotentialNearTheEquilibrium)
{
  const test::MinimalKnee knee;
  int n_reached = 0, n_cases = 0;
  for (const double sideways_n : {0.0, 3.0, -2.0}) {
    for (const double moment_nmm : {0.0, 150.0}) {
      Loads loads;
      loads.force_n = {sideways_n, 40, 0.5 * sideways_n};
      loads.moment_nmm = moment_nmm;
      const StepRecord r = knee.solve({{0, -5, 0}, 0}, 0.0, loads);
      ASSERT_EQ(r.status, StepStatus::stable);
      Landscape landscape{knee, loads};
      Vector5d offset;
      offset << 0.3, 0, -0.2, 0.25, -0.3;
      landscape.start = solve::moved(solve::configuration_at(r.pose, r.varus_rad, landscape.scale), offset,
                                     landscape.scale);
      const double found_nmm = least_by_subplex(landscape);
      // The stand-off of 1e-5 mm costs 4e-4 N mm, a step of one tolerance against 40 N ten times as much.
      EXPECT_GE(found_nmm, r.balance.energy_nmm - 5e-3);
      n_reached += found_nmm < r.balance.energy_nmm + 0.5 ? 1 : 0;
      ++n_cases;
    }
  }
  // Kinks between facets sometimes stop the simplex early.
  EXPECT_GE(n_reached, n_cases / 2);
}

}  // namespace vrda::equilibrium_test
