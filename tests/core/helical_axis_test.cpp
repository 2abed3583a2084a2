#include "model/coordinates.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/units.hpp"
#include "model/frames.hpp"

namespace vrda::helical_axis_test {

// Rounding of products of rotations applied to coordinates of a few hundred mm.
constexpr double rounding_mm = 1e-12;
constexpr double rounding = 1e-14;
constexpr double lever_mm = 150.0;  // largest distance between an axis and a query point

struct Screw {
  Eigen::Vector3d direction, point_mm;
  double rotation_rad = 0.0, translation_mm = 0.0;
};

Pose turned(const Screw& screw, double share)
{
  // By core's rotation about Z in the axis's frame, independent of the functions under test.
  const Eigen::Vector3d across = screw.direction.unitOrthogonal();
  Eigen::Matrix3d R_axis;
  R_axis << across, screw.direction.cross(across), screw.direction;
  Pose X = Pose::Identity();
  X.linear() = R_axis * rotation_z(share * screw.rotation_rad) * R_axis.transpose();
  X.translation() =
      screw.point_mm - X.linear() * screw.point_mm + share * screw.translation_mm * screw.direction;
  return X;
}

double distance_to_line_mm(const Eigen::Vector3d& p_mm, const Screw& line)
{
  return line.direction.cross(p_mm - line.point_mm).norm();
}

// Entries of products of rotations are accurate to `rounding`. The direction of a rotation by a small angle
// is accurate to rounding / angle; the resulting error of the translation across the axis, and the rounding
// of coordinates, shift the axis by 1 / angle times as much.
void expect_found(const Screw& screw, const Pose& X_start, const Eigen::Vector3d& near_mm)
{
  const double widened = 1.0 + 1.0 / screw.rotation_rad;
  const double direction_tolerance = widened * rounding;
  const double along_mm = rounding_mm + lever_mm * direction_tolerance;
  const double across_mm = widened * (rounding_mm + std::abs(screw.translation_mm) * direction_tolerance);
  const auto axis = helical_axis(X_start, turned(screw, 1.0) * X_start, near_mm);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->rotation_rad, screw.rotation_rad, rounding);
  EXPECT_NEAR(axis->translation_mm, screw.translation_mm, along_mm);
  EXPECT_LT((axis->direction - screw.direction).norm(), direction_tolerance);
  EXPECT_LT(distance_to_line_mm(axis->point_mm, screw), across_mm);
  // Nearest to the query point: the connection is perpendicular to the axis.
  EXPECT_NEAR((axis->point_mm - near_mm).dot(screw.direction), 0.0, along_mm);
}

Pose some_pose()
{
  Pose X = Pose::Identity();
  X.linear() = rotation_x(0.4) * rotation_z(-1.1) * rotation_y(0.2);
  X.translation() = Eigen::Vector3d(12.0, -35.0, 4.0);
  return X;
}

TEST(HelicalAxis, FindsScrewsOfAnyTurn)
{
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (const double angle_deg : {0.01, 0.5, 30.0, 89.0, 91.0, 150.0, 179.0}) {
    SCOPED_TRACE(angle_deg);
    for (int repeat = 0; repeat < 50; ++repeat) {
      const auto vector = [&] { return Eigen::Vector3d(number(random), number(random), number(random)); };
      const Screw screw{vector().normalized(), 50.0 * vector(), rad_from_deg(angle_deg),
                        6.0 * number(random)};
      expect_found(screw, some_pose(), 30.0 * vector());
    }
  }
}

TEST(HelicalAxis, HalfATurnIsFound)
{
  // The skew part is rounding only; either sense of the axis describes the same rotation.
  const Screw screw{Eigen::Vector3d(0.6, 0.0, -0.8), {1.0, 2.0, 3.0}, pi, 2.5};
  const auto axis = helical_axis(Pose::Identity(), turned(screw, 1.0), Eigen::Vector3d::Zero());
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->rotation_rad, pi, rounding);
  EXPECT_LT(axis->direction.cross(screw.direction).norm(), 2.0 * rounding);
  EXPECT_NEAR(std::abs(axis->translation_mm), 2.5, rounding_mm);
  EXPECT_LT(distance_to_line_mm(axis->point_mm, screw), rounding_mm);
}

TEST(HelicalAxis, PureTranslationHasNone)
{
  Pose X_end = some_pose();
  X_end.translation() += Eigen::Vector3d(1.0, 2.0, 3.0);
  EXPECT_FALSE(helical_axis(some_pose(), X_end, Eigen::Vector3d::Zero()));
  EXPECT_FALSE(instant_centre_mm(some_pose(), X_end, Eigen::Vector3d::Zero()));
  EXPECT_EQ(midpoint_orientation(some_pose(), X_end), some_pose().linear());
}

TEST(HelicalAxis, MidwayIsHalfTheTurn)
{
  const Screw screw{Eigen::Vector3d(0.36, 0.48, 0.8), {1.0, 2.0, 3.0}, rad_from_deg(40.0), 2.0};
  const Eigen::Matrix3d expected = (turned(screw, 0.5) * some_pose()).linear();
  const Eigen::Matrix3d found = midpoint_orientation(some_pose(), turned(screw, 1.0) * some_pose());
  EXPECT_LT((found - expected).norm(), 10.0 * rounding);
}

/// Intersection of the perpendicular bisectors of two points' displacements.
Eigen::Vector2d meeting_of_bisectors(const Pose& X_start, const Pose& X_end, const Eigen::Vector3d& a,
                                     const Eigen::Vector3d& b)
{
  Eigen::Matrix2d ways;
  Eigen::Vector2d levels;
  int row = 0;
  for (const Eigen::Vector3d& p : {a, b}) {
    const Eigen::Vector2d from = (X_start * p).head<2>(), to = (X_end * p).head<2>();
    ways.row(row) = (to - from).transpose();
    levels[row++] = (to - from).dot(0.5 * (from + to));
  }
  return ways.inverse() * levels;
}

TEST(InstantCentre, IsWhereTheBisectorsMeet)
{
  for (const double angle_deg : {-120.0, -5.0, 1.0, 60.0, 170.0}) {
    SCOPED_TRACE(angle_deg);
    Pose X_start = Pose::Identity();
    X_start.linear() = rotation_z(0.3);
    X_start.translation() = Eigen::Vector3d(4.0, -30.0, 7.0);
    Pose step = Pose::Identity();
    step.linear() = rotation_z(rad_from_deg(angle_deg));
    step.translation() = Eigen::Vector3d(2.0, -1.5, 0.0);
    const auto centre = instant_centre_mm(X_start, step * X_start, {5.0, 6.0, 7.0});
    ASSERT_TRUE(centre);
    const Eigen::Vector2d expected =
        meeting_of_bisectors(X_start, step * X_start, {0.0, -40.0, 1.0}, {25.0, 10.0, -3.0});
    EXPECT_LT((*centre - expected).norm(), 100.0 * rounding_mm);  // bisectors as little as 1 degree apart
  }
}

}  // namespace vrda::helical_axis_test
