// Bodies that follow the joint: closed forms of their equilibrium, derivatives, reflection, other bodies.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/units.hpp"
#include "solve/followers.hpp"
#include "solve/pins.hpp"
#include "solve/potential.hpp"

namespace vrda::followers_test {

using test::ceiling;
using test::pin;

Body body_of(const Mesh& mesh)
{
  Body body;
  body.components = {{"part", ""}};
  body.contact.mesh = mesh;
  body.contact.component.assign(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  return body;
}

// A pin with its tip at the origin, pushed up under a flat ceiling at y = 0, with another as its tibia.
job::Case pin_under_ceiling()
{
  job::Case all;
  all.reference = body_of(ceiling(200, 2, [](double, double) { return 0.0; }));
  all.moving = body_of(ceiling(20, 2, [](double, double) { return 50.0; }));
  job::Follower follower;
  follower.name = "bead";
  follower.body = body_of(pin({0, 0, 0}));
  follower.touches = {BodyIndex::reference};
  follower.delta = Eigen::Vector3d::UnitY();
  all.followers = {follower};
  return all;
}

model::Fibre line(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm, double tension_n)
{
  model::Fibre fibre;
  fibre.reference_mm = from_mm;
  fibre.moving_mm = to_mm;
  fibre.tension_n = tension_n;
  fibre.slack_length_mm = 1.0;
  fibre.to = model::follower_index(0);
  return fibre;
}

Pose shifted(const Eigen::Vector3d& t_mm)
{
  return Pose(Eigen::Translation3d(t_mm));
}

StepRecord solved(const job::Case& all, const model::BodyPoses& placed, const std::vector<Pose>& seeds)
{
  solve::FollowerSolver::Shared shared;
  return solve::FollowerSolver(all, 0, shared).solve(placed, seeds);
}

Pose pose_of(const job::Case& all, const StepRecord& record)
{
  return solve::follower_pose_of(solve::follower_frame(all, all.followers[0]), record);
}

const model::BodyPoses unmoved{Pose::Identity(), Pose::Identity()};

// Heron: of all points of a plane, light's point of reflection has the shortest way to two points above it.
TEST(Followers, LinesOfEqualTensionMeetAtThePointOfReflection)
{
  job::Case all = pin_under_ceiling();
  const Eigen::Vector3d a(-10, 20, 5), b(25, 10, -3);
  all.followers[0].ligaments.fibres = {line(a, {0, 0, 0}, 3), line(b, {0, 0, 0}, 3)};
  const StepRecord record = solved(all, unmoved, {shifted({1, -4, 2})});
  ASSERT_EQ(record.status, StepStatus::stable);
  const Eigen::Vector3d tip = pose_of(all, record) * Eigen::Vector3d::Zero();
  EXPECT_NEAR(tip.x(), (a.x() * b.y() + b.x() * a.y()) / (a.y() + b.y()), 1e-3);  // ten tolerances
  EXPECT_NEAR(tip.z(), (a.z() * b.y() + b.z() * a.y()) / (a.y() + b.y()), 1e-3);
  EXPECT_NEAR(tip.y(), 0.0, 2e-5);  // the standoff
  double up_n = 0.0;                // the ceiling's normal is vertical, whatever the pin's own direction
  for (const ContactForce& f : record.balance.forces) up_n += f.along_delta_n / -f.normal_solver.y();
  const double down_n = 3 * (a - tip).normalized().y() + 3 * (b - tip).normalized().y();
  EXPECT_NEAR(up_n, down_n, 0.01 * 6);  // the residual that a certificate allows
}

// A line from the tibia pulls to where the joint has brought the tibia.
TEST(Followers, FibresEndWhereOtherBodiesArePlaced)
{
  job::Case all = pin_under_ceiling();
  const Eigen::Vector3d on_tibia(4, 30, -6);
  model::Fibre pull = line(on_tibia, {0, 0, 0}, 5);
  pull.from = BodyIndex::moving;
  all.followers[0].ligaments.fibres = {pull};
  const Pose tibia = Eigen::Translation3d(7, -9, 3) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ());
  const StepRecord record = solved(all, {Pose::Identity(), tibia}, {shifted({1, -4, 2})});
  ASSERT_EQ(record.status, StepStatus::stable);
  const Eigen::Vector3d tip = pose_of(all, record) * Eigen::Vector3d::Zero(), end = tibia * on_tibia;
  EXPECT_NEAR(tip.x(), end.x(), 1e-3);
  EXPECT_NEAR(tip.z(), end.z(), 1e-3);
}

// A tibia lower than the ceiling stops it first, if it may touch the tibia.
TEST(Followers, TouchesTheBodiesThatItMay)
{
  job::Case all = pin_under_ceiling();
  all.followers[0].ligaments.fibres = {line({2, 40, 1}, {0, 0, 0}, 5)};
  const model::BodyPoses placed{Pose::Identity(), shifted({0, -53, 0})};  // at y = -3
  const auto tip_y = [&](const std::vector<BodyIndex>& touches) {
    all.followers[0].touches = touches;
    const StepRecord record = solved(all, placed, {shifted({0, -8, 0})});
    EXPECT_EQ(record.status, StepStatus::stable);
    return (pose_of(all, record) * Eigen::Vector3d::Zero()).y();
  };
  EXPECT_NEAR(tip_y({BodyIndex::reference}), 0.0, 2e-5);
  EXPECT_NEAR(tip_y({BodyIndex::reference, BodyIndex::moving}), -3.0, 2e-5);
  EXPECT_NEAR(tip_y({BodyIndex::moving}), -3.0, 2e-5);
}

// Two lines side by side, attached above the tip, pull the body upright; a stiff spring makes it see them as
// in the scan, where it leaned by 12 degrees.
TEST(Followers, TendonKeepsItsDirection)
{
  job::Case all = pin_under_ceiling();
  job::Follower& bead = all.followers[0];
  const Eigen::Vector3d end(0, 40, 0), attached(0, 10, 0);
  for (const Eigen::Vector3d& aside : {Eigen::Vector3d(0, 0, -4), Eigen::Vector3d(0, 0, 4)}) {
    bead.ligaments.fibres.push_back(line(end + aside, attached + aside, 2.5));
    bead.ligaments.fibres.back().bundle = "tendon";
  }
  bead.X_of_scan = Pose(Eigen::AngleAxisd(rad_from_deg(12.0), Eigen::Vector3d::UnitZ()));
  const auto seen_deg = [&](const Pose& X) {
    const Eigen::Vector3d seen = X.linear().transpose() * (end - X * attached);
    return deg_from_rad(std::atan2(seen.x(), seen.y()));
  };
  const auto solved_deg = [&] {
    const StepRecord record = solved(all, unmoved, {shifted({1, -5, 0})});
    EXPECT_EQ(record.status, StepStatus::stable);
    return seen_deg(pose_of(all, record));
  };
  EXPECT_NEAR(solved_deg(), 0.0, 0.1);  // the residual of 0.05 N at 30 mm of a line of 5 N
  bead.directions = {{"tendon", 2e4, Eigen::Vector3d::UnitZ()}};
  EXPECT_GT(seen_deg(bead.X_of_scan), 15.0);
  EXPECT_NEAR(solved_deg(), seen_deg(bead.X_of_scan), 0.1);  // 5 N at 10 mm, sine 0.3, give way by 0.04
}

TEST(Followers, OfTheSeedsTheLowestIsTaken)
{
  job::Case all = pin_under_ceiling();
  // Grooves at x = -40, 0 and 40, all as deep; the line ends above the right one.
  all.reference = body_of(
      ceiling(160, 32, [](double x, double z) { return 6.0 * std::cos(x * pi / 20.0) - 0.01 * z * z; }));
  all.followers[0].ligaments.fibres = {line({43, 200, 0}, {0, 8, 0}, 5)};
  const Pose far = shifted({-39, -20, 0}), near = shifted({38, -20, 0});
  const StepRecord of_far = solved(all, unmoved, {far}), both = solved(all, unmoved, {far, near});
  ASSERT_EQ(of_far.status, StepStatus::stable);
  EXPECT_LT(both.balance.energy_nmm, of_far.balance.energy_nmm - 1.0);
  EXPECT_EQ(both.balance.energy_nmm, solved(all, unmoved, {near, far}).balance.energy_nmm);
}

// A groove from which another leads away, at first up to 0.012 mm lower, from 3 mm on higher.
double grooves_mm(double x_mm, double z_mm)
{
  const double away_mm = z_mm - 0.4 * std::max(x_mm, 0.0);
  const double lead_mm = std::min(0.006 * std::max(x_mm, 0.0), 0.036 - 0.012 * x_mm);
  return std::max(lead_mm - 0.1 * z_mm * z_mm, -0.1 * away_mm * away_mm);
}

struct PinStep {
  double across_mm = 0.0;  // the grooves
  double energy_nmm = 0.0;
};

// The tibia draws the pin along the grooves by 1 mm a step.
std::vector<PinStep> drawn_along_grooves(BranchRule branch)
{
  job::Case all = pin_under_ceiling();
  all.reference = body_of(ceiling(44, 220, grooves_mm));
  all.spine.branch = branch;
  constexpr double far_mm = 1000, slack_mm = 900, stiffness_n = 500;
  for (const double side : {-1.0, 1.0}) {
    model::Fibre fibre = test::fibre({side * far_mm, 0, 0}, {0, 0, 0}, slack_mm);
    fibre.stiffness_n = stiffness_n;
    fibre.from = BodyIndex::moving;
    fibre.to = model::follower_index(0);
    all.followers[0].ligaments.fibres.push_back(fibre);
  }
  all.followers[0].ligaments.fibres.push_back(line({0, far_mm, 0}, {0, 20, 0}, 30));
  all.followers[0].X_of_scan = shifted({-2, -3, 0});
  solve::SweepPlan plan;
  plan.varus_rad = {0.0};
  solve::SweepResult result;
  for (std::int32_t i = 0; i <= 20; ++i) {
    all.grid.flexion_deg.push_back(1e-6 * i);  // the tibia only moves along
    plan.flexion_rad.push_back(rad_from_deg(all.grid.flexion_deg.back()));
    StepRecord cell;
    cell.key = {StepKind::row, i, 0};
    cell.status = StepStatus::stable;
    cell.pose.translation_mm = {i - 2.0, 0, 0};
    result.cells.push_back(cell);
    result.spine_column.push_back(0);
  }
  all.push.resize(plan.flexion_rad.size());
  EXPECT_TRUE(solve::follow(all, plan, {}, {}, 1, result));
  std::vector<PinStep> steps;
  for (const std::vector<StepRecord>& of_cell : result.followers) {
    EXPECT_EQ(of_cell[0].status, StepStatus::stable) << steps.size();
    steps.push_back(
        {(pose_of(all, of_cell[0]) * Eigen::Vector3d::Zero()).z(), of_cell[0].balance.energy_nmm});
  }
  return steps;
}

double largest_change_mm(const std::vector<PinStep>& steps)
{
  double largest_mm = 0.0;
  for (std::size_t i = 1; i < steps.size(); ++i)
    largest_mm = std::max(largest_mm, std::abs(steps[i].across_mm - steps[i - 1].across_mm));
  return largest_mm;
}

TEST(Followers, TheContinuousPathTakesABranchWhereItBegins)
{
  const std::vector<PinStep> lowest = drawn_along_grooves(BranchRule::lowest);
  const std::vector<PinStep> continuous = drawn_along_grooves(BranchRule::continuous);
  // The second groove is 0.4 mm further away each step: reached at 4 mm, and where it begins to exist, at 3.
  constexpr double facets_mm = 0.1;
  EXPECT_NEAR(largest_change_mm(lowest), 1.6, facets_mm);
  EXPECT_NEAR(largest_change_mm(continuous), 1.2, facets_mm);
  ASSERT_EQ(lowest.size(), continuous.size());
  double above_nmm = 0.0;
  for (std::size_t i = 0; i < lowest.size(); ++i)
    above_nmm = std::max(above_nmm, continuous[i].energy_nmm - lowest[i].energy_nmm);
  EXPECT_GT(above_nmm, 0.1);
  EXPECT_LT(above_nmm, 30 * 0.02) << "the lead of the first groove";
}

TEST(Followers, LeftIsTheReflectionOfRightBitForBit)
{
  job::Case right = pin_under_ceiling();
  right.reference =
      body_of(ceiling(60, 12, [](double x, double z) { return -0.01 * (x * x + 2 * z * z) + 0.02 * x; }));
  right.followers[0].centre_mm = {1, -2, 0.5};
  right.followers[0].delta = Eigen::Vector3d(-0.2, 1, 0.1).normalized();
  model::Fibre tendon = line({12, 25, 4}, {0.5, 8, 1}, 5);
  tendon.bundle = "tendon";
  right.followers[0].ligaments.fibres = {tendon, line({-9, 30, -7}, {-0.5, 9, -1}, 4)};
  right.followers[0].directions = {{"tendon", 500.0, Eigen::Vector3d(0.1, 0, 1).normalized()}};
  job::Case left = right;
  left.frame.side = Side::left;
  const auto mirrored = [](Eigen::Vector3d v) {
    v.z() = -v.z();
    return v;
  };
  left.reference.contact.mesh = mirrored_z(right.reference.contact.mesh);
  left.followers[0].body.contact.mesh = mirrored_z(right.followers[0].body.contact.mesh);
  left.followers[0].centre_mm = mirrored(left.followers[0].centre_mm);
  left.followers[0].delta = mirrored(left.followers[0].delta);
  left.followers[0].directions[0].axis = mirrored(left.followers[0].directions[0].axis);
  for (model::Fibre& fibre : left.followers[0].ligaments.fibres) {
    fibre.reference_mm = mirrored(fibre.reference_mm);
    fibre.moving_mm = mirrored(fibre.moving_mm);
  }
  const StepRecord of_right = solved(right, unmoved, {shifted({2, -9, 1})});
  const StepRecord of_left = solved(left, unmoved, {shifted({2, -9, -1})});
  ASSERT_EQ(of_right.status, StepStatus::stable);
  EXPECT_EQ(of_left.balance.energy_nmm, of_right.balance.energy_nmm);
  const JointCoordinates q =
      follower_coordinates(pose_of(right, of_right), Side::right, right.followers[0].centre_mm);
  EXPECT_EQ(follower_coordinates(pose_of(left, of_left), Side::left, left.followers[0].centre_mm), q);
  EXPECT_GT(q.head<3>().norm(), 0.01);
}

TEST(FollowerCoordinates, PoseAndCoordinatesAreInverse)
{
  JointCoordinates q;
  q << 0.7, -0.2, 0.3, 4, -30, 2;
  for (const Side side : {Side::right, Side::left}) {
    const Eigen::Vector3d centre(53, 5, side == Side::left ? -4 : 4);
    const Pose X = follower_pose(q, side, centre);
    EXPECT_LT((follower_coordinates(X, side, centre) - q).norm(), 1e-13);
    EXPECT_LT((X * centre - centre - Eigen::Vector3d(4, -30, side == Side::left ? -2 : 2)).norm(), 1e-12);
  }
}

TEST(DirectionSpring, WrenchMatchesDifferences)
{
  const solve::JointMap map(SolverFrame{});
  DirectionSpring spring;
  spring.stiffness_nmm = 700.0;
  spring.reference_mm = {5, -40, 3};
  spring.moving_mm = {2, -8, 1};
  spring.axis = Eigen::Vector3d(0.2, -0.1, 1).normalized();
  spring.rest = spring.axis.cross(Eigen::Vector3d(0.8, 0.3, 0.1)).normalized();
  JointCoordinates q;
  q << 0.4, 0.1, -0.2, 3, -25, 5;
  const solve::SolverPosition here = map.position_at(q);
  solve::Vector6d wrench = solve::Vector6d::Zero();
  const auto energy_at = [&](const JointCoordinates& c) {
    solve::Vector6d unused = solve::Vector6d::Zero();
    return solve::energy_of(spring, map.position_at(c), unused);
  };
  EXPECT_GT(solve::energy_of(spring, here, wrench), 10.0);
  const solve::Vector6d slope = map.twists(q, here).transpose() * wrench;
  for (Eigen::Index k = 0; k < 6; ++k) {
    constexpr double h = 1e-5;
    JointCoordinates up = q, down = q;
    up(k) += h;
    down(k) -= h;
    EXPECT_NEAR((energy_at(up) - energy_at(down)) / (2.0 * h), slope(k), 1e-4) << k;  // of up to 700 N mm
  }
}

}  // namespace vrda::followers_test
