// The equilibrium with contact and without ligaments.
#include "solve/equilibrium.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "geometry/shapes.hpp"
#include "solve/pins.hpp"
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

TEST(Equilibrium, ItsIteratesAreInContactAndEndAtTheResult)
{
  const solve::Joint joint = joint_of(ceiling(60, 12, pit), pins({{-2, 0, 0}, {3, 0, 1}}));
  const model::Ligaments none;
  solve::EquilibriumSolver solver(joint, none, options);
  std::mt19937_64 random(4);
  int n_iterates = 0;
  for (int k = 0; k < 20; ++k) {
    const solve::EquilibriumSolver::Task task{{}, random_seed(random, 20), {}};
    std::vector<SearchMove> moves;
    const StepRecord r = solver.solve(task, [&](const SearchMove& move) { moves.push_back(move); });
    const StepRecord unwatched = solver.solve(task);
    EXPECT_EQ(unwatched.pose.translation_mm, r.pose.translation_mm);
    EXPECT_EQ(unwatched.queries, r.queries);
    ASSERT_EQ(r.status, StepStatus::stable);
    geometry::GapQuery gap(joint.reference_gap, joint.moving_gap);
    gap.set_attitude({});
    int last = 0;
    const SearchMove* end = nullptr;
    for (const SearchMove& move : moves) {
      EXPECT_GE(move.iteration, last);
      last = move.iteration;
      EXPECT_EQ(move.in_contact, move.kind == MoveKind::iterate);
      if (!move.in_contact) continue;
      EXPECT_NEAR(gap.travel_mm(move.pose), standoff_mm, 1e-9);
      ASSERT_FALSE(move.contacts.empty());
      for (const ContactRecord& c : move.contacts) {
        EXPECT_NEAR(c.normal_solver.norm(), 1.0, 1e-12);
        EXPECT_LT(c.normal_solver.y(), 0.0);
      }
      end = &move;
      ++n_iterates;
    }
    ASSERT_NE(end, nullptr);
    EXPECT_EQ(end->pose.translation_mm, r.pose.translation_mm);
    EXPECT_EQ(end->pose.theta_rad, r.pose.theta_rad);
  }
  EXPECT_GT(n_iterates, 60);
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
    EXPECT_TRUE(r.contact_medial && r.contact_lateral);
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
  EXPECT_TRUE(r.contact_lateral);
  EXPECT_FALSE(r.contact_medial);
  EXPECT_NEAR(r.gap_medial_mm, 3.0, 1e-3);
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
    geometry::GapQuery medial(joint.reference_gap, joint.medial_gap),
        lateral(joint.reference_gap, joint.lateral_gap);
    medial.set_attitude(attitude);
    lateral.set_attitude(attitude);
    EXPECT_NEAR(r.gap_medial_mm, medial.travel_mm(r.pose), 1e-9);
    EXPECT_NEAR(r.gap_lateral_mm, lateral.travel_mm(r.pose), 1e-9);
    EXPECT_NEAR(std::min(r.gap_medial_mm, r.gap_lateral_mm), standoff_mm, 1e-9);
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

}  // namespace vrda::equilibrium_test
