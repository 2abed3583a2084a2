// Paths over bone: the taut string, its side, its ends.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.hpp"
#include "geometry/laid_path.hpp"
#include "support/meshes.hpp"

namespace vrda::laid_path_test {

using Eigen::Vector3d;
using geometry::BesidePath, geometry::LazyDistance;

constexpr double radius_mm = 20.0, clearance_mm = 1.0;
constexpr double sampled_mm = 0.2;  // trilinear between nodes 2 mm apart on a sphere of 20 mm: 2^2 / 20

Body body_of(Mesh mesh)
{
  Body body;
  body.components = {{"bone", "bone"}};
  body.contact.component.assign(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  body.contact.mesh = std::move(mesh);
  return body;
}

using Path = std::array<Vector3d, 24>;

Path line(const Vector3d& from_mm, const Vector3d& to_mm)
{
  Path path;
  for (std::size_t k = 0; k < path.size(); ++k)
    path[k] = from_mm + static_cast<double>(k) / static_cast<double>(path.size() - 1) * (to_mm - from_mm);
  return path;
}

double length_mm(const Path& path)
{
  double sum = 0.0;
  for (std::size_t k = 1; k < path.size(); ++k) sum += (path[k] - path[k - 1]).norm();
  return sum;
}

TEST(LaidPath, IsATautStringOverABall)
{
  LazyDistance ball(body_of(test::ball(radius_mm, 64, 128)));
  const std::array<BesidePath, 1> beside{BesidePath{&ball, Pose::Identity()}};
  const double high_mm = radius_mm + clearance_mm;
  for (const double off_mm : {-12.0, -4.0, 4.0, 12.0}) {
    SCOPED_TRACE(off_mm);
    const Vector3d from_mm(-35, off_mm, 0), to_mm(35, off_mm, 0);
    Path path = line(from_mm, to_mm);
    EXPECT_TRUE(geometry::lay_over(path, beside, clearance_mm));
    EXPECT_EQ(path.front(), from_mm);
    EXPECT_EQ(path.back(), to_mm);
    for (const Vector3d& p_mm : path) {
      EXPECT_GE(p_mm.norm(), high_mm - sampled_mm);
      EXPECT_GE(p_mm.y() * off_mm, 0.0);  // on its side
    }
    // Two tangents and the arc between them.
    const double distance_mm = from_mm.norm(),
                 tangent_mm = std::sqrt(distance_mm * distance_mm - high_mm * high_mm);
    const double between_rad = std::acos(from_mm.dot(to_mm) / (distance_mm * distance_mm));
    const double arc_rad = between_rad - 2.0 * std::acos(high_mm / distance_mm);
    EXPECT_NEAR(length_mm(path), 2.0 * tangent_mm + high_mm * arc_rad, 0.01 * distance_mm);
  }
}

TEST(LaidPath, KeepsEveryBitOfAClearOne)
{
  LazyDistance ball(body_of(test::ball(radius_mm)));
  const std::array<BesidePath, 1> beside{BesidePath{&ball, Pose::Identity()}};
  const Path clear = line({-35, 22, 0}, {35, 22, 0});
  Path path = clear;
  EXPECT_FALSE(geometry::lay_over(path, beside, clearance_mm));
  EXPECT_EQ(path, clear);
}

TEST(LaidPath, MovesWithTheBody)
{
  LazyDistance ball(body_of(test::ball(radius_mm)));
  const Pose X = Eigen::Translation3d(5, -8, 3) * Eigen::AngleAxisd(1.1, Vector3d(1, 2, -2).normalized());
  Path path = line({-35, 4, 0}, {35, 6, 5}), moved = path;
  for (Vector3d& p_mm : moved) p_mm = X * p_mm;
  geometry::lay_over(path, std::array{BesidePath{&ball, Pose::Identity()}}, clearance_mm);
  geometry::lay_over(moved, std::array{BesidePath{&ball, X}}, clearance_mm);
  for (std::size_t k = 0; k < path.size(); ++k) EXPECT_LT((moved[k] - X * path[k]).norm(), 1e-9);
}

// A damaged file may hold a body of any size; its grid is coarser then, not larger.
TEST(LaidPath, AHugeBodyHasFewNodes)
{
  constexpr double huge_mm = 1e9;
  LazyDistance ball(body_of(test::ball(huge_mm)));
  EXPECT_NEAR(ball.sample(Vector3d::Zero()).distance_mm, -huge_mm, 0.02 * huge_mm);
  EXPECT_GT(ball.sample({2.0 * huge_mm, 0, 0}).distance_mm, 0.0);
}

// Deep in a slab the other face is nearer; the ends are on this one.
TEST(LaidPath, StaysOnTheSideOfItsEnds)
{
  LazyDistance slab(body_of(test::box({0, 0, 0}, {60, 20, 120})));
  const std::array<BesidePath, 1> beside{BesidePath{&slab, Pose::Identity()}};
  Path path = line({0, 10, -50}, {0, 10, 50});
  for (std::size_t k = 1; k + 1 < path.size(); ++k) path[k].y() = -4.0;
  EXPECT_TRUE(geometry::lay_over(path, beside, clearance_mm));
  for (std::size_t k = 2; k + 2 < path.size(); ++k) EXPECT_NEAR(path[k].y(), 10.0 + clearance_mm, sampled_mm);
}

TEST(LaidPath, LeavesBoneFromABuriedEnd)
{
  LazyDistance slab(body_of(test::box({0, 0, 0}, {60, 20, 120})));
  const std::array<BesidePath, 1> beside{BesidePath{&slab, Pose::Identity()}};
  Path path = line({0, 6, -50}, {0, 10, 50});  // 4 mm deep
  EXPECT_TRUE(geometry::lay_over(path, beside, clearance_mm));
  EXPECT_EQ(path.front(), Vector3d(0, 6, -50));
  double lowest_mm = 1e9;
  for (const Vector3d& p_mm : path) {
    const double from_ends_mm = std::min((p_mm - path.front()).norm(), (p_mm - path.back()).norm());
    if (from_ends_mm > 8.0) lowest_mm = std::min(lowest_mm, p_mm.y());
  }
  EXPECT_NEAR(lowest_mm, 10.0 + clearance_mm, sampled_mm);
}

}  // namespace vrda::laid_path_test
