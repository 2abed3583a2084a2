// A wheel on a plane: rolling and sliding in closed form.
#include "analysis/reduce.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"

namespace vrda::analysis::rolling_test {

constexpr double rounding_mm = 1e-12;
constexpr double radius_mm = 22.0;

/// A wheel (reference, axis Z, centre at its origin) on a plane (moving, Y = 0), flexed and `x_mm` forward.
CompartmentContact wheel_on_plane(double flexion_rad, double x_mm)
{
  Pose X_moving_reference = Pose::Identity();
  X_moving_reference.linear() = rotation_z(flexion_rad);
  X_moving_reference.translation() = Eigen::Vector3d(x_mm, radius_mm, 0.0);
  CompartmentContact contact;
  contact.X_reference_moving = X_moving_reference.inverse();
  contact.p_moving_mm = {x_mm, 0.0, 0.0};
  contact.p_reference_mm = contact.X_reference_moving * contact.p_moving_mm;
  return contact;
}

// The wheel's contact moves back by the chord of the turn, that of the plane by the way of the wheel.
TEST(Rolling, IsTheCommonWayAndSlidingTheDifference)
{
  struct Row {
    const char* name;
    double turn_deg, forward_mm;
    bool rolls_by_turn;  ///< else by the way on the plane
  };
  for (const Row& row : {Row{"spins in place", 3.0, 0.0, false}, Row{"locked", 0.0, -2.5, true},
                         Row{"a condyle: rolls back a third, slides forward", 6.0, -0.7, false},
                         Row{"skids further than it turns", 2.0, -2.3, true}}) {
    SCOPED_TRACE(row.name);
    const double turn_rad = rad_from_deg(row.turn_deg), chord_mm = 2.0 * radius_mm * sine(0.5 * turn_rad);
    const Rolling found =
        rolling_between(wheel_on_plane(0.2, 4.0), wheel_on_plane(0.2 + turn_rad, 4.0 + row.forward_mm));
    EXPECT_NEAR(found.reference_mm, -chord_mm, rounding_mm);
    EXPECT_NEAR(found.moving_mm, row.forward_mm, rounding_mm);
    EXPECT_NEAR(found.rolling_mm, row.rolls_by_turn ? -chord_mm : row.forward_mm, rounding_mm);
    EXPECT_NEAR(found.sliding_mm, row.forward_mm + chord_mm, rounding_mm);
  }
  // Opposite ways share nothing.
  EXPECT_EQ(rolling_between(wheel_on_plane(0.2, 0.0), wheel_on_plane(0.25, 1.0)).rolling_mm, 0.0);
}

TEST(Rolling, AWheelThatRollsDoesNotSlide)
{
  const double turn_rad = rad_from_deg(1.0);
  for (const double start_deg : {0.0, 45.0, 130.0}) {
    SCOPED_TRACE(start_deg);
    const double start_rad = rad_from_deg(start_deg), end_rad = start_rad + turn_rad;
    const CompartmentContact start = wheel_on_plane(start_rad, -radius_mm * start_rad);
    const CompartmentContact end = wheel_on_plane(end_rad, -radius_mm * end_rad);
    const Rolling rolling = rolling_between(start, end);
    // With increasing flexion it rolls backwards. A chord is shorter than its arc by angle^2 / 24.
    const double arc_mm = radius_mm * turn_rad, sagged_mm = arc_mm * turn_rad * turn_rad / 24.0;
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

}  // namespace vrda::analysis::rolling_test
