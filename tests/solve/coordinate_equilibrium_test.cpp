// Equilibrium with roles for each of the joint's coordinates: closed forms, derivatives and the other solver.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/units.hpp"
#include "solve/coordinate_equilibrium.hpp"
#include "solve/pins.hpp"
#include "solve/potential.hpp"
#include "solve/stability_search.hpp"

namespace vrda::coordinate_equilibrium_test {

const EquilibriumOptions options;
constexpr double standoff_mm = 1e-5;
using Free = std::array<bool, n_joint_coordinates>;
using Task = solve::CoordinateEquilibrium::Task;
using test::ceiling;
using test::joint_of;
using test::pins;

JointCoordinates at(double flexion, double varus, double internal, double ant, double prox, double lat)
{
  JointCoordinates q;
  q << rad_from_deg(flexion), rad_from_deg(varus), rad_from_deg(internal), ant, prox, lat;
  return q;
}

StepRecord solved(const solve::Joint& joint, const JointCoordinates& seed, const Free& is_free,
                  const Loads& loads = {}, const model::Ligaments& ligaments = {})
{
  return solve::CoordinateEquilibrium(joint, ligaments, SolverFrame{}, options)
      .solve({seed, is_free, loads, true});
}

JointCoordinates coordinates_of(const StepRecord& r)
{
  return solve::JointMap(SolverFrame{}).coordinates_at({{r.coordinates->flexion_rad, r.varus_rad}, r.pose});
}

SolverFrame tilted(Side side)
{
  SolverFrame frame;
  frame.side = side;
  frame.delta = Eigen::Vector3d(0.3, 0.9, side == Side::left ? -0.2 : 0.2).normalized();
  return frame;
}

TEST(SolverPosition, IsTheInverseOfThePose)
{
  constexpr double rounding = 1e-12;  // mm or rad, coordinates of hundreds of mm
  for (const Side side : {Side::right, Side::left}) {
    for (const Eigen::Vector3d& delta : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(-1, 0, 0),
                                         Eigen::Vector3d(Eigen::Vector3d(0.3, 1, -0.2).normalized())}) {
      for (const double flexion_rad : {-2.9, 0.0, 1.1, 3.0}) {
        const SolverFrame frame{side, {430.0, 510.0, side == Side::left ? -75.0 : 75.0}, delta};
        const MovingPose pose{{1.25, -3.5, 0.75}, -0.21};
        const solve::SolverPosition found =
            solve::solver_position(frame, X_reference_moving(frame, {flexion_rad, 0.07}, pose));
        EXPECT_NEAR(found.attitude.flexion_rad, flexion_rad, rounding);
        EXPECT_NEAR(found.attitude.varus_rad, 0.07, rounding);
        EXPECT_NEAR(found.pose.theta_rad, -0.21, rounding);
        EXPECT_LT((found.pose.translation_mm - pose.translation_mm).norm(), rounding);
      }
    }
  }
}

// The displacement of a moving point and of its own position in the reference, by central differences.
TEST(JointMap, TwistsMatchDifferences)
{
  for (const SolverFrame& frame : {SolverFrame{}, tilted(Side::right), tilted(Side::left)}) {
    const solve::JointMap map(frame);
    const JointCoordinates q = at(40, 7, -12, 3, -25, 5);
    const solve::SolverPosition here = map.position_at(q);
    const solve::Matrix6d twists = map.twists(q, here);
    const Eigen::Vector3d p_moving(11, -4, 6);
    const auto in_reference = [&](const JointCoordinates& c) {
      const solve::SolverPosition s = map.position_at(c);
      return Eigen::Vector3d(reference_rotation(s.attitude).transpose() * (pose_of(s.pose) * p_moving));
    };
    const Eigen::Vector3d p = pose_of(here.pose) * p_moving;
    for (Eigen::Index k = 0; k < 6; ++k) {
      constexpr double h = 1e-5;
      JointCoordinates up = q, down = q;
      up(k) += h;
      down(k) -= h;
      const Eigen::Vector3d by_difference =
          reference_rotation(here.attitude) * (in_reference(up) - in_reference(down)) / (2.0 * h);
      const Eigen::Vector3d by_twist =
          twists.col(k).tail<3>() + twists.col(k).head<3>().cross(p - here.pose.translation_mm);
      EXPECT_LT((by_difference - by_twist).norm(), 1e-7) << k;  // rounding of 1e-14 x 40 mm / 1e-5
    }
    EXPECT_LT((map.coordinates_at(here) - q).norm(), 1e-12);
  }
}

TEST(JointMap, WorkOfLoadsMatchesDifferences)
{
  const solve::JointMap map(tilted(Side::right));
  Loads loads;
  loads.force_n = {3, 20, -5};
  loads.moment_nmm = 150;
  loads.varus_moment_nmm = -80;
  loads.point_mm = {7, 2, -9};
  loads.applied = {{BodyIndex::reference, {2, -3, 4}, {0, 0, 0}, {5, -6, 7}},
                   {BodyIndex::moving, {1, 2, 3}, {50, 0, -20}, {4, 4, -4}}};
  loads.lines = {{35, {10, 20, 5}, {-3, -8, 6}}};
  const JointCoordinates q = at(40, 7, -12, 3, -25, 5);
  const solve::SolverPosition here = map.position_at(q);
  const solve::LoadPotential applied = solve::potential_near(loads, here.attitude, here.pose);
  const solve::Vector6d by_twist =
      map.twists(q, here).transpose() * solve::work_of(loads, &applied, here).wrench;
  for (Eigen::Index k = 0; k < 6; ++k) {
    constexpr double h = 1e-5;
    JointCoordinates up = q, down = q;
    up(k) += h;
    down(k) -= h;
    const double by_difference = (solve::work_of(loads, &applied, map.position_at(up)).work_nmm -
                                  solve::work_of(loads, &applied, map.position_at(down)).work_nmm) /
                                 (2.0 * h);
    EXPECT_NEAR(by_difference, by_twist(k), 1e-5) << k;  // rounding of 1e-13 x 500 N mm / 1e-5
  }
}

TEST(FeatureDistance, MatchesDifferences)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * number(random), size * number(random), size * number(random));
  };
  using Kind = solve::ContactConstraint::Kind;
  const solve::JointMap map(SolverFrame{});
  const Eigen::Vector3d pivot(2, 0, -3);
  for (const Kind kind : {Kind::face_of_reference, Kind::face_of_moving, Kind::edges}) {
    for (int n = 0; n < 20; ++n) {
      solve::ContactConstraint c;
      c.kind = kind;
      c.reference_mm = vector(20);
      c.moving_mm = vector(20);
      c.reference_direction = vector(1).normalized();
      c.moving_direction = vector(1).normalized();
      const JointCoordinates q = at(30, 5, 10, 2, -20, 3);
      const solve::SolverPosition here = map.position_at(q);
      const solve::FeatureDistance d = solve::FeatureMeter(here, pivot)(c);
      const solve::Vector6d slope = map.twists(q, here).transpose() * d.wrench;
      for (Eigen::Index k = 0; k < 6; ++k) {
        constexpr double h = 1e-6;
        JointCoordinates up = q, down = q;
        up(k) += h;
        down(k) -= h;
        const double by_difference = (solve::FeatureMeter(map.position_at(up), pivot)(c).distance_mm -
                                      solve::FeatureMeter(map.position_at(down), pivot)(c).distance_mm) /
                                     (2.0 * h);
        // Rounding of 1e-14 x 40 mm / 1e-6, more where the edges are nearly parallel.
        EXPECT_NEAR(by_difference, slope(k), 1e-5 * (1.0 + slope.norm()))
            << static_cast<int>(kind) << ' ' << k;
      }
    }
  }
}

// Three tips in three V grooves that meet at 120 degrees hold all six coordinates.
Mesh three_grooves()
{
  Mesh all;
  for (const double angle : {0.0, 120.0, 240.0}) {
    Mesh groove;
    groove.vertices_mm.resize(6, 3);
    groove.vertices_mm << 5, 0, 0, 35, 0, 0, 5, -8, -8, 35, -8, -8, 5, -8, 8, 35, -8, 8;
    groove.triangles.resize(4, 3);
    groove.triangles << 0, 3, 1, 0, 2, 3, 1, 4, 0, 1, 5, 4;
    groove.vertices_mm = groove.vertices_mm * rotation_y(rad_from_deg(angle)).transpose();
    groove.normals = vertex_normals(groove);
    append(all, groove);
  }
  return all;
}

solve::Joint seat()
{
  std::vector<Eigen::Vector3d> tips;
  for (const double angle : {0.0, 120.0, 240.0})
    tips.push_back(rotation_y(rad_from_deg(angle)) * Eigen::Vector3d(20, 0, 0));
  return joint_of(three_grooves(), pins(tips));
}

TEST(CoordinateEquilibrium, SixFreeCoordinatesOnAThreePointSeat)
{
  const StepRecord r = solved(seat(), at(2, -1.5, 3, 0.7, -4, -0.5), {true, true, true, true, true, true});
  ASSERT_EQ(r.status, StepStatus::stable);
  const JointCoordinates q = coordinates_of(r);
  // The standoff of each flank moves the seat down by root 2 of it; facets are exact.
  EXPECT_LT(q.head<3>().norm(), 1e-6);
  EXPECT_LT(std::hypot(q(3), q(5)), 1e-4);
  EXPECT_NEAR(q(4), -std::sqrt(2.0) * standoff_mm, 1e-6);
  ASSERT_EQ(r.balance.forces.size(), 6u);
  for (const ContactForce& f : r.balance.forces) EXPECT_NEAR(f.along_delta_n, 20.0 / 6.0, 1e-2);
  for (const std::int8_t determined : r.coordinates->determined) EXPECT_EQ(determined, 1);
}

// y = -slope |z|: a groove along X.
double groove(double, double z)
{
  return -0.5 * std::abs(z);
}

TEST(CoordinateEquilibrium, APegWithItsRotationGiven)
{
  const solve::Joint joint = joint_of(ceiling(80, 4, groove), pins({{20, 0, 0}, {-20, 0, 0}}));
  const double turn = rad_from_deg(5.0);
  const StepRecord r = solved(joint, at(0, 0, 5, 1, -10, 0.4), {false, false, false, true, true, true});
  ASSERT_EQ(r.status, StepStatus::stable);
  const JointCoordinates q = coordinates_of(r);
  // The tips are 20 sin(5 degrees) off the groove's bottom, where it is half as deep.
  EXPECT_NEAR(q(2), turn, 1e-15);
  EXPECT_NEAR(q(4), -0.5 * 20.0 * std::sin(turn), 2e-5);
  EXPECT_NEAR(q(5), 0.0, 1e-4);
  // The moment that holds it: the push times the height's derivative.
  EXPECT_NEAR(r.coordinates->holding[2], 20.0 * 0.5 * 20.0 * std::cos(turn), 0.05);
  EXPECT_TRUE(std::isnan(r.coordinates->holding[4]));
  EXPECT_EQ(r.coordinates->determined[3], 0);  // the groove has no end within reach
  EXPECT_EQ(r.coordinates->determined[5], 1);
  EXPECT_EQ(r.coordinates->determined[2], -1);

  const StepRecord free = solved(joint, at(0, 0, 5, 1, -10, 0.4), {false, false, true, true, true, true});
  ASSERT_EQ(free.status, StepStatus::stable);
  EXPECT_NEAR(coordinates_of(free)(2), 0.0, 1e-5);
  EXPECT_EQ(free.coordinates->determined[2], 1);
}

TEST(CoordinateEquilibrium, AppliedAndHoldingForcesAreEqual)
{
  // All coordinates but the height held on a flat ceiling: they resist exactly what is applied.
  const solve::Joint joint = joint_of(ceiling(80, 4, [](double, double) { return 0.0; }),
                                      pins({{20, 0, 0}, {-10, 0, 15}, {-10, 0, -15}}));
  Loads loads;
  loads.force_n = {4, 30, -7};
  loads.moment_nmm = 55;
  // In world axes, at a point of the moving object 12 mm forwards: 6 N to the right turn it by -72 N mm.
  loads.applied = {
      {BodyIndex::world, {0, 0, 6}, {0, 0, 0}, rotation_y(rad_from_deg(-3)) * Eigen::Vector3d(12, 0, 0)}};
  const StepRecord r =
      solved(joint, at(0, 0, 3, 0.5, -3, -0.2), {false, false, false, false, true, false}, loads);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR(coordinates_of(r)(4), -standoff_mm, 1e-8);
  EXPECT_NEAR(r.coordinates->holding[2], -55.0 + 72.0, 1e-6);
  EXPECT_NEAR(r.coordinates->holding[3], -4.0, 1e-6);
  EXPECT_NEAR(r.coordinates->holding[5], 1.0, 1e-6);
}

TEST(CoordinateEquilibrium, ABallInASocketWithAllRotationsGiven)
{
  // Socket of radius 14 about the rotation centre, ball of 10 about its own: 4 mm apart along Delta.
  const Mesh bowl =
      ceiling(16, 64, [](double x, double z) { return std::sqrt(14.0 * 14.0 - x * x - z * z); });
  const solve::Joint joint = joint_of(bowl, test::ball(10.0, 96, 192));
  const StepRecord r = solved(joint, at(12, -5, 25, 0.5, -6, 0.3), {false, false, false, true, true, true});
  ASSERT_EQ(r.status, StepStatus::stable);
  const JointCoordinates q = coordinates_of(r);
  // Facets of the socket (0.36 mm edges) are up to 2e-3 mm inside it, those of the ball up to 1.3e-3 mm.
  EXPECT_NEAR(q(4), 4.0, 4e-3);
  // Across Delta a facet's edge away: the ball rests between three vertices of the socket's grid.
  EXPECT_LT(std::abs(q(3)), 0.36);
  EXPECT_LT(std::abs(q(5) - 4.0 * std::sin(q(1))), 0.36);
  EXPECT_NEAR(q(0), rad_from_deg(12), 1e-15);
}

TEST(CoordinateEquilibrium, APlateUnderACylinderSlidesFreely)
{
  // A cylinder of radius 15 along Z about the rotation centre; the plate may slide forwards at no cost.
  Mesh cylinder = ceiling(20, 40, [](double x, double) { return -std::sqrt(15.0 * 15.0 - x * x); });
  Mesh plate = test::sheet(60, 2);
  const solve::Joint joint = solve::make_joint({cylinder, {}}, {plate, {}}, {});
  const StepRecord r = solved(joint, at(10, 0, 0, 3, -20, 0), {false, false, false, true, true, false});
  ASSERT_EQ(r.status, StepStatus::stable);
  const JointCoordinates q = coordinates_of(r);
  EXPECT_NEAR(q(4), -15.0, 15.0 * (1.0 - std::cos(0.5 * 0.5 / 15.0)) + 2e-5);  // the prism's sagitta
  EXPECT_NEAR(q(3), 3.0, 1e-3);                                                // where the seed was
  EXPECT_EQ(r.coordinates->determined[3], 0);
  EXPECT_EQ(r.coordinates->determined[4], 1);
  EXPECT_NEAR(r.coordinates->holding[5], 0.0, 1e-6);
}

TEST(CoordinateEquilibrium, HeightGivenLeavesTheFreeRestOrSaysWhyNot)
{
  const solve::Joint joint = joint_of(ceiling(80, 4, groove), pins({{20, 0, 0}, {-20, 0, 0}}));
  const Free only_across{false, false, false, false, false, true};
  // At 3 mm below the groove's bottom the tips have 6 mm to either side; the side force brings them there.
  Loads loads;
  loads.force_n = {0, 20, 5};
  const StepRecord r = solved(joint, at(0, 0, 0, 0, -3, 0), only_across, loads);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR(coordinates_of(r)(5), 6.0, 1e-4);
  // The flank's force: 5 N across at a slope of one half is 10 N along Delta. 20 are applied.
  EXPECT_NEAR(r.coordinates->holding[4], -10.0, 1e-3);
  // 1 mm above the bottom nothing is free.
  EXPECT_EQ(solved(joint, at(0, 0, 0, 0, 1, 0), only_across, loads).status, StepStatus::no_clearance);
}

TEST(CoordinateEquilibrium, AgreesWithTheOtherSolver)
{
  const auto bowl = [](double x, double z) { return -0.01 * (x * x + z * z) - 0.002 * x * z; };
  const solve::Joint joint =
      joint_of(ceiling(80, 40, bowl), pins({{20, 0, 3}, {-10, 0, 15}, {-10, 0, -15}, {12, -1, -9}}));
  model::Ligaments ligaments;
  ligaments.fibres = {test::fibre({0, 30, 20}, {0, -15, 22}, 42),
                      test::fibre({5, 25, -20}, {8, -12, -22}, 36)};
  Loads loads;
  loads.moment_nmm = 30;
  loads.applied = {{BodyIndex::moving, {0.5, 1, -0.4}, {5, 20, -6}, {6, -5, 3}}};
  loads.lines = {{4, {15, 20, 3}, {12, -10, -2}}};
  for (const bool is_varus_free : {false, true}) {
    const StepRecord other = solve::EquilibriumSolver(joint, ligaments, options)
                                 .solve({{0.1, 0.02}, {{0.4, -8, 0.3}, 0.1}, loads, is_varus_free});
    const StepRecord r =
        solved(joint, at(deg_from_rad(0.1), deg_from_rad(0.02), deg_from_rad(0.1), 0.4, -8, 0.3),
               {false, is_varus_free, true, true, true, true}, loads, ligaments);
    ASSERT_EQ(other.status, StepStatus::stable);
    ASSERT_EQ(r.status, StepStatus::stable);
    // Both stop within a tolerance of 1e-4 mm of height; facets make the rest as sharp.
    EXPECT_NEAR(r.balance.energy_nmm, other.balance.energy_nmm, 20.0 * 1e-4);
    EXPECT_LT((r.pose.translation_mm - other.pose.translation_mm).norm(), 2e-3);
    EXPECT_NEAR(r.pose.theta_rad, other.pose.theta_rad, 1e-4);
    EXPECT_NEAR(r.varus_rad, other.varus_rad, 1e-4);
    EXPECT_NEAR(r.balance.flexion_moment_nmm, other.balance.flexion_moment_nmm,
                1e-3 * std::abs(other.balance.flexion_moment_nmm) + 0.5);
    EXPECT_NEAR(r.balance.varus_moment_nmm, other.balance.varus_moment_nmm,
                1e-3 * std::abs(other.balance.varus_moment_nmm) + 0.5);
  }
}

TEST(HeldSearch, KeepsWhatIsHeldAndFindsTheRest)
{
  const solve::Joint joint = joint_of(ceiling(80, 4, groove), pins({{20, 0, 0}, {-20, 0, 0}}));
  const double turn = rad_from_deg(5.0);
  SearchOptions search;
  search.held.theta = true;
  const StepRecord turned = solve::find_stable_pose(joint, {}, {{1, -10, 1.3}, turn}, search);
  ASSERT_EQ(turned.status, StepStatus::stable);
  EXPECT_EQ(turned.pose.theta_rad, turn);
  // Within the resolution of 0.1 mm across, half of it in height.
  EXPECT_NEAR(turned.pose.translation_mm.z(), 0.0, 0.1);
  EXPECT_NEAR(turned.pose.translation_mm.y(), -0.5 * 20.0 * std::sin(turn), 0.1);
  search.held = {false, true, false};
  const StepRecord aside = solve::find_stable_pose(joint, {}, {{1, -10, 1.3}, turn}, search);
  ASSERT_EQ(aside.status, StepStatus::stable);
  EXPECT_EQ(aside.pose.translation_mm.z(), 1.3);
  // Turning about its own axis lets the nearer tip rise until both are 1.3 mm off the bottom.
  EXPECT_NEAR(aside.pose.theta_rad, 0.0, rad_from_deg(0.5));
  EXPECT_NEAR(aside.pose.translation_mm.y(), -0.65, 0.1);
  search.held = {true, true, true};
  const StepRecord only_up = solve::find_stable_pose(joint, {}, {{1, -10, 1.3}, turn}, search);
  ASSERT_EQ(only_up.status, StepStatus::stable);
  EXPECT_NEAR(only_up.pose.translation_mm.y(), -0.5 * (20.0 * std::sin(turn) + 1.3), 2e-3);
}

}  // namespace vrda::coordinate_equilibrium_test
