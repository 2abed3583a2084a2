#include "report/outline.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.hpp"

namespace vrda::outline_test {

constexpr double rounding = 1e-9;

TEST(Outline, OfABoxIsItsRectangle)
{
  const auto rim = outline(test::box({5, 0, -3}, {8, 2, 6}), {.from_mm = -1, .to_mm = 1, .n_directions = 36});
  ASSERT_EQ(rim.size(), 36u);
  for (const Eigen::Vector2d& p : rim) {
    const double x = std::fabs(p.x() - 5.0) / 4.0, z = std::fabs(p.y() + 3.0) / 3.0;
    EXPECT_NEAR(std::max(x, z), 1.0, rounding);
  }
}

TEST(Outline, OfABallIsItsCircle)
{
  const int n_sectors = 64;
  const auto rim = outline(test::ball(10, 32, n_sectors), {.from_mm = -10, .to_mm = 10});
  ASSERT_EQ(rim.size(), 240u);
  const double sagitta_mm = 10.0 * (1.0 - std::cos(3.15 / n_sectors));
  for (const Eigen::Vector2d& p : rim) EXPECT_NEAR(p.norm(), 10.0, sagitta_mm + rounding);
}

TEST(Outline, CountsTrianglesWithinTheHeightsOnly)
{
  Mesh mesh = test::box({0, 0, 0}, {2, 2, 2});
  append(mesh, test::box({0, 50, 0}, {20, 2, 20}));
  for (const Eigen::Vector2d& p : outline(mesh, {.from_mm = -1, .to_mm = 1}))
    EXPECT_LE(p.norm(), std::sqrt(2.0) + rounding);
  EXPECT_TRUE(outline(mesh, {.from_mm = 5, .to_mm = 6}).empty());
  EXPECT_TRUE(outline(Mesh{}, {.from_mm = -1, .to_mm = 1}).empty());
}

}  // namespace vrda::outline_test
