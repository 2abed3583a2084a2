// Range of motion of a ball with a neck in a cup, whose boundary has a closed form; the highest seat.
#include <gtest/gtest.h>
#include <cmath>
#include <limits>

#include "analysis/ball_in_cup.hpp"
#include "analysis/range_of_motion.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::analysis::range_of_motion_test {

using namespace test::cup;

/// Angle of the neck from -Y of the cup.
double tilt_rad(double flexion_rad, double varus_rad, double internal_rad)
{
  JointCoordinates q = JointCoordinates::Zero();
  q.head<3>() << flexion_rad, varus_rad, internal_rad;
  return std::acos(std::clamp(joint_pose(q).linear()(1, 1), -1.0, 1.0));
}

// The neck's cylinder touches the rim, a circle around Y, as seen from the ball's centre in its seat.
double largest_tilt_rad(double depth = depth_mm)
{
  const double rim_mm = std::sqrt(cup_mm * cup_mm - depth * depth);
  const double below_mm = depth + (cup_mm - ball_mm);
  return std::atan2(rim_mm, below_mm) - std::asin(neck_mm / std::hypot(rim_mm, below_mm));
}

template <typename Check>
void for_each_cell(const RangeOfMotion& range, const Check& check)
{
  for (std::size_t cell = 0; cell < range.cells.size(); ++cell)
    check(range.cells[cell], Eigen::Vector3d(range.axes.rotations_at(cell).data()));
}

void expect_boundary(const RangeOfMotion& range)
{
  int n_inside = 0, n_outside = 0;
  for_each_cell(range, [&](const RomCell& cell, const Eigen::Vector3d& q) {
    const double tilt = tilt_rad(q[0], q[1], q[2]);
    SCOPED_TRACE(testing::Message() << "flexion " << deg_from_rad(q[0]) << ", varus " << deg_from_rad(q[1])
                                    << ", internal " << deg_from_rad(q[2]));
    if (tilt < largest_tilt_rad() - step_rad) {
      ++n_inside;
      EXPECT_EQ(cell.status, RomStatus::in_range);
      EXPECT_TRUE(cell.is_connected);
    } else if (tilt > largest_tilt_rad() + step_rad) {
      ++n_outside;
      EXPECT_EQ(cell.status, RomStatus::contact);
      EXPECT_FALSE(cell.is_connected);
      EXPECT_GT(cell.opening_mm, range.limits.opening_mm);
    }
  });
  EXPECT_GT(n_inside, 300);
  EXPECT_GT(n_outside, 100);
}

TEST(RangeOfMotion, EndsWhereTheNeckMeetsTheRim)
{
  const RangeOfMotion range = range_of_motion(ball_in_cup(), cup_plan(2, step_rad));
  expect_boundary(range);
  // The ball's centre rises by the clearance, to the height of the facets.
  EXPECT_NEAR((range.X_neutral * Eigen::Vector3d::Zero()).y(), cup_mm - ball_mm, 0.05);
}

TEST(RangeOfMotion, ThreeRotations)
{
  RomPlan plan = cup_plan(2, 3.0 * step_rad);
  plan.axes.rad = {angles_rad(68), {-step_rad, 0.0, step_rad}, {-8.0 * step_rad, 0.0, 8.0 * step_rad}};
  const RangeOfMotion range = range_of_motion(ball_in_cup(), plan);
  for_each_cell(range, [&](const RomCell& cell, const Eigen::Vector3d& q) {
    const double tilt = tilt_rad(q[0], q[1], q[2]);
    const bool is_inside = tilt < largest_tilt_rad() - step_rad;
    const bool is_outside = tilt > largest_tilt_rad() + step_rad;
    EXPECT_TRUE(!is_inside || cell.status == RomStatus::in_range);
    EXPECT_TRUE(!is_outside || cell.status == RomStatus::contact);
  });
}

TEST(RangeOfMotion, ALeftJointHasTheRangeOfItsMirrorImage)
{
  job::Case right = ball_in_cup();
  // Without the symmetry of the cup.
  right.reference.contact.mesh.vertices_mm.col(2).array() += 0.1;
  job::Case left = right;
  left.frame.side = Side::left;
  left.reference = mirrored_z(right.reference);
  left.moving = mirrored_z(right.moving);
  RomPlan plan = cup_plan(2, 3.0 * step_rad);
  plan.axes.rad[1] = {-0.6, -0.2, 0.0, 0.3, 0.7};
  plan.axes.rad[2] = {-0.4, 0.0, 0.5};
  const RangeOfMotion a = range_of_motion(right, plan), b = range_of_motion(left, plan);
  for (std::size_t k = 0; k < a.cells.size(); ++k) {
    EXPECT_EQ(a.cells[k].status, b.cells[k].status);
    EXPECT_NEAR(a.cells[k].opening_mm, b.cells[k].opening_mm, 1e-4) << "the seat is found to 1e-5 mm";
  }
}

TEST(RangeOfMotion, ABallAloneHasNoEndUnderADeltaOfEitherBody)
{
  job::Case joint = ball_in_cup();
  Profile ball;
  add_arc(ball, ball_mm, 0.0, pi);
  set_body(joint.moving, "head", revolved(ball));
  RomPlan plan = cup_plan(2, 3.0 * step_rad);
  for (const BodyIndex body : {BodyIndex::moving, BodyIndex::reference}) {
    plan.delta_body = body;
    // Fixed to the ball, Delta leans by the rotation; the ball must enter the cup along it, past the rim.
    const double largest = body == BodyIndex::moving ? 0.08 : 1.2;
    plan.axes.rad[0] = plan.axes.rad[1] = {-largest, 0.0, largest};
    plan.axes.rad[2] = {-1.0, 0.0, 1.0};
    plan.limits.translation_mm = 2.0;
    const RangeOfMotion range = range_of_motion(joint, plan);
    EXPECT_EQ(volume_of(range).n_cells, range.cells.size());
  }
}

// A fibre along Y from the cup's top to the head's: its length changes with the tilt alone.
TEST(RangeOfMotion, AFibreEndsItAtItsStrain)
{
  job::Case joint = ball_in_cup();
  const double clearance_mm = cup_mm - ball_mm;
  model::Fibre fibre;
  fibre.name = fibre.bundle = "round ligament";
  fibre.reference_mm = {0, 40, 0};
  fibre.moving_mm = {0, 10, 0};  // turns aside about the ball's centre
  fibre.stiffness_n = 1000.0;
  fibre.slack_length_mm = 30.0 - clearance_mm;  // in the neutral seat
  joint.ligaments.fibres = {fibre};
  RomPlan plan = cup_plan(2, 3.0 * step_rad);
  plan.limits.strain = 0.03;
  const RangeOfMotion range = range_of_motion(joint, plan);
  const auto strain_at = [&](double tilt) {
    const double up_mm = 40.0 - clearance_mm - 10.0 * std::cos(tilt), aside_mm = 10.0 * std::sin(tilt);
    return std::hypot(up_mm, aside_mm) / fibre.slack_length_mm - 1.0;
  };
  int n_fibre = 0;
  for_each_cell(range, [&](const RomCell& cell, const Eigen::Vector3d& q) {
    const double tilt = tilt_rad(q[0], q[1], q[2]);
    if (tilt > largest_tilt_rad() - step_rad) return;
    // The seat moves by the height of the facets.
    EXPECT_NEAR(cell.largest_strain, strain_at(tilt), 0.1 / fibre.slack_length_mm);
    if (strain_at(tilt) > 0.035) {
      ++n_fibre;
      EXPECT_EQ(cell.status, RomStatus::fibre);
    } else if (strain_at(tilt) < 0.025) {
      EXPECT_EQ(cell.status, RomStatus::in_range);
    }
  });
  EXPECT_GT(n_fibre, 5);
}

TEST(RangeOfMotion, ContactWhereASheetEndsIsNamed)
{
  job::Case joint = ball_in_cup();
  set_body(joint.reference, "cup", cup_sheet());
  RomPlan plan = cup_plan(2, 3.0 * step_rad);
  // The neck lifts the ball a little while it is at the rim.
  plan.limits = {3.0, 1.5, 0.1};
  const RangeOfMotion range = range_of_motion(joint, plan);
  int n_border = 0;
  for_each_cell(range, [&](const RomCell& cell, const Eigen::Vector3d& q) {
    const double tilt = tilt_rad(q[0], q[1], q[2]);
    n_border += cell.status == RomStatus::border ? 1 : 0;
    EXPECT_TRUE(cell.status != RomStatus::border || tilt > largest_tilt_rad(sheet_depth_mm) - step_rad);
    EXPECT_TRUE(tilt > largest_tilt_rad(sheet_depth_mm) - step_rad || cell.status == RomStatus::in_range);
  });
  EXPECT_GT(n_border, 3);
}

// An offset of the neck alone: the ball keeps its seat, and the boundary moves by the angle of the closed
// form.
TEST(RangeOfMotion, AnOffsetMovesTheBoundary)
{
  constexpr double offset_mm = 1.0, fine_rad = rad_from_deg(0.5);
  RomPlan plan = cup_plan(2, step_rad);
  plan.axes.rad[0].clear();
  for (double a = 0.0; a < rad_from_deg(75.0); a += fine_rad) plan.axes.rad[0].push_back(a);
  plan.axes.rad[1] = {0.0, 1e-3};
  const auto end_rad = [&](const job::Case& joint) {
    const RangeOfMotion range = range_of_motion(joint, plan);
    double end = 0.0;
    for_each_cell(range, [&](const RomCell& cell, const Eigen::Vector3d& q) {
      if (cell.status == RomStatus::in_range && q[1] == 0.0) end = std::max(end, q[0]);
    });
    return end;
  };
  job::Case joint = ball_in_cup();
  const double bare_rad = end_rad(joint);
  Mesh& mesh = joint.moving.contact.mesh;
  for (Eigen::Index k = 0; k < mesh.triangles.rows(); ++k) {
    const Eigen::RowVector3d centroid =
        (mesh.vertices_mm.row(mesh.triangles(k, 0)) + mesh.vertices_mm.row(mesh.triangles(k, 1)) +
         mesh.vertices_mm.row(mesh.triangles(k, 2))) /
        3.0;
    mesh.offset_mm.push_back(centroid.norm() > ball_mm ? offset_mm : 0.0);
  }
  const double rim_mm = std::sqrt(cup_mm * cup_mm - depth_mm * depth_mm);
  const double from_centre_mm = std::hypot(rim_mm, depth_mm + cup_mm - ball_mm);
  const double shift_rad =
      std::asin(neck_mm / from_centre_mm) - std::asin((neck_mm + offset_mm) / from_centre_mm);
  EXPECT_NEAR(end_rad(joint) - bare_rad, shift_rad, 1.5 * fine_rad)
      << "each end is known to a step, less what the limits give way";
  EXPECT_LT(end_rad(joint), bare_rad);
}

TEST(RangeOfMotion, ABallBesideTheCupHasNoSeat)
{
  job::Case joint = ball_in_cup();
  joint.reference.contact.mesh.vertices_mm.col(0).array() += 200.0;
  EXPECT_THROW(range_of_motion(joint, cup_plan(2, 3.0 * step_rad)), InputError);
}

Mesh mesh_of(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& faces)
{
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(points.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t k = 0; k < points.size(); ++k)
    mesh.vertices_mm.row(static_cast<Eigen::Index>(k)) = points[k].transpose();
  for (std::size_t k = 0; k < faces.size(); ++k)
    mesh.triangles.row(static_cast<Eigen::Index>(k)) << faces[k][0], faces[k][1], faces[k][2];
  return mesh;
}

/// Four planes over the square |x|, |z| <= 20, seen from below: 10 - 0.5 max(|x|, |z|) high.
Mesh tent()
{
  return mesh_of({{0, 10, 0}, {20, 0, 20}, {20, 0, -20}, {-20, 0, -20}, {-20, 0, 20}},
                 {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}});
}

/// A tip at the origin, 2 mm deep.
Mesh tip()
{
  return mesh_of({{0, 0, 0}, {1, -2, 1}, {1, -2, -1}, {-1, -2, -1}, {-1, -2, 1}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {1, 3, 2}, {1, 4, 3}});
}

Seat seat_from(const SeatTask& task)
{
  const geometry::GapTree reference(tent()), moving(tip());
  geometry::GapQuery query(reference, moving);
  query.set_attitude({});
  return highest_seat(query, task);
}

constexpr double tolerance_mm = 1e-5;  // promised for heights

TEST(HighestSeat, IsTheTopOfATent)
{
  for (const Eigen::Vector2d& from :
       {Eigen::Vector2d(3, 2), Eigen::Vector2d(-11, 4), Eigen::Vector2d(0, 0)}) {
    const Seat seat = seat_from({{}, std::numeric_limits<double>::infinity(), from});
    ASSERT_TRUE(seat.is_found && seat.is_converged);
    EXPECT_NEAR(seat.pose.translation_mm.y(), 10.0, tolerance_mm);
    // The slope of the tent is a half.
    EXPECT_LE(seat.pose.translation_mm.cwiseAbs().maxCoeff(), 10.0 + tolerance_mm);
    EXPECT_NEAR(seat.pose.translation_mm.x(), 0.0, 2.0 * tolerance_mm);
    EXPECT_NEAR(seat.pose.translation_mm.z(), 0.0, 2.0 * tolerance_mm);
  }
}

TEST(HighestSeat, StaysWithinTheLimit)
{
  const MovingPose centre{{6, 0, 3}, 0};
  const Seat seat = seat_from({centre, 1.0, {0.5, -0.5}});
  ASSERT_TRUE(seat.is_found && seat.is_converged);
  EXPECT_NEAR(seat.pose.translation_mm.x(), 5.0, tolerance_mm);
  EXPECT_NEAR(seat.pose.translation_mm.y(), 7.5, tolerance_mm);
  EXPECT_GE(seat.pose.translation_mm.z(), 2.0 - tolerance_mm);
  EXPECT_LE(seat.pose.translation_mm.z(), 4.0 + tolerance_mm);
}

}  // namespace vrda::analysis::range_of_motion_test
