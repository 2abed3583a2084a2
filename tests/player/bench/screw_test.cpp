#include "bench/rigid_body.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "player/bench/moves.hpp"

namespace vrda::screw_test {

/// Rounding of a dozen operations on numbers of 1000 mm.
constexpr double rounding_mm = 5e-12;
constexpr double rounding_rad = 2e-15;

TEST(Screw, AQuarterTurnAboutALineIsTheClosedForm)
{
  // About the line through (10, 0, 0) along Z, rising by 8 mm: turn = pi/2 z, shift = -turn x point + rise.
  const Eigen::Vector3d turn(0, 0, pi / 2), point(10, 0, 0), rise(0, 0, 8);
  const Pose X = bench::pose_of(bench::Screw{turn, rise - turn.cross(point)});
  EXPECT_LT((X * Eigen::Vector3d(13, 0, 0) - Eigen::Vector3d(10, 3, 8)).norm(), rounding_mm);
  EXPECT_LT((X * Eigen::Vector3d(10, 0, 5) - Eigen::Vector3d(10, 0, 13)).norm(), rounding_mm);
}

TEST(Screw, LogarithmAndExponentialUndoEachOther)
{
  std::mt19937_64 random(11);
  // Both sides of each bound between a series and the closed form, up to half a turn.
  for (const double angle_rad :
       {0.0, 1e-12, 1e-8, 0.99e-4, 1.01e-4, 1e-3, 0.0999, 0.1001, 1.0, 3.0, pi - 1e-9}) {
    SCOPED_TRACE(angle_rad);
    for (int i = 0; i < 50; ++i) {
      const bench::Screw screw{angle_rad * test::random_vector(random, 1.0).normalized(),
                               test::random_vector(random, 1000.0)};
      const bench::Screw back = bench::screw_of(bench::pose_of(screw));
      EXPECT_LT((back.turn_rad - screw.turn_rad).norm(), 10 * rounding_rad);
      EXPECT_LT((back.shift_mm - screw.shift_mm).norm(), 10 * rounding_mm);
    }
  }
}

TEST(Screw, MidwayIsTheHelicalAxisOfCore)
{
  std::mt19937_64 random(13);
  for (int i = 0; i < 100; ++i) {
    const Pose start = test::random_pose(random), end = test::random_pose(random);
    const Pose midway = bench::between(start, end, 0.5);
    EXPECT_LT((midway.linear() - midpoint_orientation(start, end)).norm(), 1e-12);
    // The remaining motion is along the same screw.
    const Pose X_done = start.inverse() * midway, X_left = midway.inverse() * end;
    EXPECT_LT((X_done.matrix() - X_left.matrix()).norm(), 1e-9);
    EXPECT_LT(test::distance_mm(bench::between(start, end, 1.0), end), 1e-9);
  }
}

}  // namespace vrda::screw_test
