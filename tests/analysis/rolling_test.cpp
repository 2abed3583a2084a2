#include "analysis/reduce.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"

namespace vrda::rolling_test {

constexpr double rounding_mm = 1e-12;
constexpr double radius_mm = 22.0;

/// A wheel (reference, axis Z, centre at its origin) on a plane (moving, Y = 0), flexed and `x_mm` forward.
analysis::CompartmentContact wheel_on_plane(double flexion_rad, double x_mm)
{
  Pose X_moving_reference = Pose::Identity();
  X_moving_reference.linear() = rotation_z(flexion_rad);
  X_moving_reference.translation() = Eigen::Vector3d(x_mm, radius_mm, 0.0);
  analysis::CompartmentContact bearing;
  bearing.X_reference_moving = X_moving_reference.inverse();
  bearing.p_moving_mm = {x_mm, 0.0, 0.0};
  bearing.p_reference_mm = bearing.X_reference_moving * bearing.p_moving_mm;
  return bearing;
}

/// Chord of an arc of the wheel.
double chord_mm(double turn_rad)
{
  return 2.0 * radius_mm * sine(0.5 * turn_rad);
}

TEST(Rolling, AWheelThatRollsDoesNotSlide)
{
  const double turn_rad = rad_from_deg(1.0);
  for (const double start_deg : {0.0, 45.0, 130.0}) {
    SCOPED_TRACE(start_deg);
    const double start_rad = rad_from_deg(start_deg), end_rad = start_rad + turn_rad;
    const analysis::CompartmentContact start = wheel_on_plane(start_rad, -radius_mm * start_rad);
    const analysis::CompartmentContact end = wheel_on_plane(end_rad, -radius_mm * end_rad);
    const analysis::Rolling rolling = analysis::rolling_between(start, end);
    // With increasing flexion it rolls backwards. A chord is shorter than its arc by angle^2 / 24.
    const double arc_mm = radius_mm * turn_rad, sagged_mm = arc_mm * turn_rad * turn_rad / 24.0;
    EXPECT_NEAR(rolling.moving_mm, -arc_mm, rounding_mm);
    EXPECT_NEAR(rolling.reference_mm, -chord_mm(turn_rad), rounding_mm);
    EXPECT_NEAR(rolling.rolling_mm, -arc_mm, sagged_mm);
    EXPECT_NEAR(rolling.sliding_mm, 0.0, sagged_mm);
    // The centre of the finite rotation is on the radius to the mid-contact: r (a / 2) / sin(a / 2).
    const auto centre_mm =
        instant_centre_mm(start.X_reference_moving, end.X_reference_moving, Eigen::Vector3d::Zero());
    ASSERT_TRUE(centre_mm);
    const Eigen::Vector3d middle = rotation_z(-0.5 * (start_rad + end_rad)) * Eigen::Vector3d(0.0, -1.0, 0.0);
    const double expected_mm = radius_mm * 0.5 * turn_rad / sine(0.5 * turn_rad);
    EXPECT_LT((*centre_mm - expected_mm * middle.head<2>()).norm(), rounding_mm / turn_rad);
  }
}

TEST(Rolling, AWheelThatSpinsInPlaceOnlySlides)
{
  const double turn_rad = rad_from_deg(3.0);
  const analysis::Rolling rolling =
      analysis::rolling_between(wheel_on_plane(0.5, 4.0), wheel_on_plane(0.5 + turn_rad, 4.0));
  EXPECT_NEAR(rolling.moving_mm, 0.0, rounding_mm);
  EXPECT_NEAR(rolling.reference_mm, -chord_mm(turn_rad), rounding_mm);
  EXPECT_NEAR(rolling.rolling_mm, 0.0, rounding_mm);
  // Its lowest point moves forward over the plane.
  EXPECT_NEAR(rolling.sliding_mm, chord_mm(turn_rad), rounding_mm);
}

TEST(Rolling, ALockedWheelOnlySlides)
{
  const analysis::Rolling rolling =
      analysis::rolling_between(wheel_on_plane(0.7, 4.0), wheel_on_plane(0.7, 1.5));
  EXPECT_NEAR(rolling.reference_mm, 0.0, rounding_mm);
  EXPECT_NEAR(rolling.rolling_mm, 0.0, rounding_mm);
  EXPECT_NEAR(rolling.sliding_mm, -2.5, rounding_mm);
}

TEST(Rolling, AKneesCondyleRollsBackAndSlidesForward)
{
  // A third of the pure rolling travel; forward sliding compensates the rest.
  const double turn_rad = rad_from_deg(6.0), back_mm = radius_mm * turn_rad / 3.0;
  const analysis::Rolling rolling =
      analysis::rolling_between(wheel_on_plane(0.2, 0.0), wheel_on_plane(0.2 + turn_rad, -back_mm));
  EXPECT_NEAR(rolling.rolling_mm, -back_mm, rounding_mm);
  EXPECT_NEAR(rolling.sliding_mm, chord_mm(turn_rad) - back_mm, rounding_mm);
}

TEST(Rolling, ASkidFurtherThanTheWheelTurnsRollsByItsTurn)
{
  const double turn_rad = rad_from_deg(2.0), back_mm = 3.0 * radius_mm * turn_rad;
  const analysis::Rolling rolling =
      analysis::rolling_between(wheel_on_plane(0.2, 0.0), wheel_on_plane(0.2 + turn_rad, -back_mm));
  EXPECT_NEAR(rolling.rolling_mm, -chord_mm(turn_rad), rounding_mm);
  EXPECT_NEAR(rolling.sliding_mm, chord_mm(turn_rad) - back_mm, rounding_mm);
}

TEST(Rolling, OppositeWaysShareNothing)
{
  const double turn_rad = rad_from_deg(2.0);
  const analysis::Rolling rolling =
      analysis::rolling_between(wheel_on_plane(0.2, 0.0), wheel_on_plane(0.2 + turn_rad, 1.0));
  EXPECT_EQ(rolling.rolling_mm, 0.0);
  EXPECT_NEAR(rolling.sliding_mm, 1.0 + chord_mm(turn_rad), rounding_mm);
}

}  // namespace vrda::rolling_test
