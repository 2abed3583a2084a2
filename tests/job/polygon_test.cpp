#include "job/clean_mesh.hpp"

#include <gtest/gtest.h>

#include <random>

#include "model/frames.hpp"

namespace vrda::polygon_test {

// Rounding of a few products of coordinates up to 10.
constexpr double rounding = 1e-12;

Points flat(const std::vector<Eigen::Vector2d>& outline)
{
  Points corners(static_cast<Eigen::Index>(outline.size()), 3);
  for (std::size_t k = 0; k < outline.size(); ++k) {
    corners.row(static_cast<Eigen::Index>(k)) << outline[k].x(), outline[k].y(), 0.0;
  }
  return corners;
}

double outline_area(const std::vector<Eigen::Vector2d>& outline)
{
  double doubled = 0.0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
    doubled += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * doubled;
}

// Crossing number; `p` must not be on the outline.
bool is_inside(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p)
{
  bool inside = false;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
    const bool spans = (a.y() > p.y()) != (b.y() > p.y());
    if (spans && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

// The triangles have the winding of the outline, are inside it, and their areas add up to its area.
void expect_covers(const std::vector<Eigen::Vector2d>& outline, const Eigen::Matrix3d& R)
{
  const Points corners = flat(outline) * R.transpose();
  const auto triangles = job::triangulate(corners);
  EXPECT_EQ(triangles.size(), outline.size() - 2);
  double area = 0.0;
  for (const auto& t : triangles) {
    const Eigen::Vector2d &a = outline[static_cast<std::size_t>(t[0])],
                          &b = outline[static_cast<std::size_t>(t[1])],
                          &c = outline[static_cast<std::size_t>(t[2])];
    const double doubled = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    EXPECT_GT(doubled, 0.0);
    EXPECT_TRUE(is_inside(outline, (a + b + c) / 3.0));
    area += 0.5 * doubled;
  }
  EXPECT_NEAR(area, outline_area(outline), rounding);
}

const std::vector<Eigen::Vector2d> l_shape{{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
const std::vector<Eigen::Vector2d> arrow{{0, 0}, {4, 2}, {0, 4}, {1, 2}};

TEST(Polygon, concave_outlines)
{
  // Also a comb, and a square with extra collinear corners.
  const std::vector<Eigen::Vector2d> comb{{0, 0}, {7, 0}, {7, 3}, {6, 3}, {6, 1},
                                          {5, 1}, {5, 3}, {4, 3}, {4, 1}, {0, 1}};
  const std::vector<Eigen::Vector2d> dotted{{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
  for (std::vector<Eigen::Vector2d> outline : {l_shape, arrow, comb, dotted}) {
    for (std::size_t first = 0; first < outline.size(); ++first) {
      SCOPED_TRACE(first);
      expect_covers(outline, Eigen::Matrix3d::Identity());
      std::rotate(outline.begin(), outline.begin() + 1, outline.end());
    }
  }
}

TEST(Polygon, random_stars)
{
  std::mt19937 random(7);
  int n_concave = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Eigen::Vector2d> star;
    for (int k = 0; k < 24; ++k) {
      const Eigen::Vector3d arm =
          rotation_z(0.26 * k) * Eigen::Vector3d(1.0 + static_cast<double>(random() % 1000) / 200.0, 0, 0);
      star.emplace_back(arm.x(), arm.y());
    }
    // 23 x 0.26 = 5.98 rad in all: the outline makes one turn and does not cross itself.
    expect_covers(star, rotation_x(0.1 * trial));
    n_concave += star[1].norm() < 0.5 * (star[0].norm() + star[2].norm()) ? 1 : 0;
  }
  EXPECT_GT(n_concave, 10);
}

TEST(Polygon, triangle_and_line)
{
  EXPECT_EQ(job::triangulate(flat({{0, 0}, {1, 0}, {0, 1}})),
            (std::vector<std::array<std::int32_t, 3>>{{0, 1, 2}}));
  EXPECT_TRUE(job::triangulate(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}})).empty());
}

}  // namespace vrda::polygon_test
