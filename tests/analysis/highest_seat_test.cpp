#include "analysis/range_of_motion.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace vrda::analysis::highest_seat_test {

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

}  // namespace vrda::analysis::highest_seat_test
