// Thesis 4.2.1: a ball dropped anywhere above a dish ends at its centre and is never rotated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "validation/scene_case.hpp"

namespace vrda::test::ball_test {

// Half the angle between neighbouring corners of an icosahedron; that of a facet is this over the
// subdivision.
constexpr double icosahedron_edge_rad = 1.1071487177940904;

struct BallCase {
  geometry::ShapeRequest request;
  SearchOptions options;
  Eigen::Vector3d ball_mm;   ///< the ball's centre, in the moving mesh
  double facet_mm = 0.0;     ///< edge of the ball's facets
  double triangle_mm = 0.0;  ///< edge of the dish's triangles
  double dish_mm = 0.0;      ///< half the dish's width
};

enum class Size { smaller_than_a_triangle, any, as_large_as_the_dish };

// A dish and a ball below it. Both have so many facets that the equilibrium of the polygons is within a
// resolution of the centre. The ball's axis starts at least one of its facets inside the border, since a
// facet parallel to the border's edge is inclined outward as often as inward.
BallCase drawn(Draw& draw, const std::string& section, Size size, bool is_stretched)
{
  BallCase result;
  const double width_mm = draw.uniform(24, 60);
  const double dish_radius_mm = width_mm / std::sqrt(2.0) / 0.95 * draw.uniform(1.0, 2.5);
  const int dish_edges = draw.whole(12, 28);
  result.dish_mm = 0.5 * width_mm;
  result.triangle_mm = result.dish_mm / dish_edges;
  double ball_mm = draw.log_uniform(0.5, 0.97 * dish_radius_mm);
  if (size == Size::smaller_than_a_triangle) ball_mm = draw.uniform(0.25, 0.45) * result.triangle_mm;
  if (size == Size::as_large_as_the_dish)
    ball_mm = std::min(0.97 * dish_radius_mm, draw.uniform(0.7, 1.0) * width_mm);
  const int ball_edges = draw.whole(8, 20);
  // Flatter or taller, and up to a fifth wider one way: a wide one with the dish's curvature
  // would have its equilibrium on the border.
  const Eigen::Vector3d stretch =
      is_stretched ? Eigen::Vector3d(draw.uniform(0.6, 1.0), draw.uniform(0.6, 1.6), draw.uniform(0.6, 1.0))
                   : Eigen::Vector3d(1, 1, 1);
  result.facet_mm = ball_mm * icosahedron_edge_rad / ball_edges;
  const double reach_mm = std::max(0.0, 0.95 * result.dish_mm - result.facet_mm);
  const double x_mm = draw.uniform(-reach_mm, reach_mm), z_mm = draw.uniform(-reach_mm, reach_mm);
  result.ball_mm = {x_mm, 0.0, z_mm};
  result.request = {"ball-in-dish",
                    {{"ball_radius", ball_mm},
                     {"stretch_x", stretch.x()},
                     {"stretch_y", stretch.y()},
                     {"stretch_z", stretch.z()},
                     {"dish_radius", dish_radius_mm},
                     {"dish_width", width_mm},
                     {"ball_edges", ball_edges},
                     {"dish_edges", dish_edges},
                     {"offset_x", x_mm},
                     {"offset_z", z_mm}},
                    {{"section", section}}};
  // Steps up to the size of the ball, resolutions at most a tenth of them (thesis 4.2.1).
  result.options.translation_step_mm = draw.log_uniform(0.5, std::max(1.0, ball_mm));
  result.options.translation_resolution_mm = std::min(0.1, 0.1 * result.options.translation_step_mm);
  return result;
}

double from_middle_resolutions(const BallCase& ball, const Solved& solved)
{
  const Eigen::Vector3d middle = placed(solved, ball.ball_mm);
  return std::hypot(middle.x(), middle.z()) / ball.options.translation_resolution_mm;
}

void expect_rest_in_the_middle(Tally tally, const std::string& section, Size size, bool is_stretched,
                               int n_cases)
{
  tally.claim = "ends in the middle";
  tally.measure = "distance from the middle, translation resolutions";
  tally.allowed = 2.0;  // halving from 1 mm can leave an error of 1.25
  Draw draw(tally.seed);
  for (int k = 0; k < n_tested(n_cases); ++k) {
    const BallCase ball = drawn(draw, section, size, is_stretched);
    const Solved solved = solve(scene_of(ball.request), ball.options);
    ++tally.outcomes[std::string(name_of(solved.record.status))];
    EXPECT_TRUE(tally.add(from_middle_resolutions(ball, solved)))
        << "case " << k << " of " << section << ", step " << ball.options.translation_step_mm << " mm, "
        << testing::PrintToString(ball.request.numbers);
  }
  report(tally);
}

TEST(BallInDish, EndsInTheMiddleOfABowl)
{
  expect_rest_in_the_middle({.scene = "ball in a dish, bowl", .seed = 101}, "bowl", Size::any, false, 300);
}
TEST(BallInDish, EndsInTheMiddleOfACone)
{
  expect_rest_in_the_middle({.scene = "ball in a dish, cone", .seed = 102}, "cone", Size::any, false, 300);
}
TEST(BallInDish, EndsInTheMiddleOfANonMonotoneSlope)
{
  expect_rest_in_the_middle({.scene = "ball in a dish, non-monotone slope", .seed = 103}, "wave", Size::any,
                            false, 300);
}
TEST(BallInDish, ABallSmallerThanATriangleEndsInTheMiddle)
{
  expect_rest_in_the_middle({.scene = "ball smaller than a triangle of the dish", .seed = 104}, "bowl",
                            Size::smaller_than_a_triangle, false, 200);
}
TEST(BallInDish, ABallAsLargeAsTheDishEndsInTheMiddle)
{
  expect_rest_in_the_middle({.scene = "ball as large as the dish", .seed = 105}, "bowl",
                            Size::as_large_as_the_dish, false, 200);
}
TEST(BallInDish, AnEllipsoidEndsInTheMiddle)
{
  expect_rest_in_the_middle({.scene = "ellipsoid in a dish", .seed = 106}, "bowl", Size::any, true, 300);
}

// A normal interpolated from a ball's analytic ones points away from the ball's centre C at every point of
// a facet. So the moments about the mean B of any contact points, weighted by their distances from C, sum
// to (C - B) x (C - B) = 0: they cannot all have the same sign. Facet normals do produce torques.
TEST(BallInDish, AnalyticNormalsNeverTurnTheBall)
{
  Tally tally{.scene = "ball with analytic normals",
              .claim = "no torque where none exists",
              .measure = "turns",
              .seed = 107};
  Draw draw(tally.seed);
  int n_slides = 0, n_wide = 0;
  for (int k = 0; k < n_tested(300); ++k) {
    BallCase ball = drawn(draw, k % 3 == 0 ? "bowl" : k % 3 == 1 ? "cone" : "wave", Size::any, false);
    ball.options.normals = ContactNormals::moving;
    const Solved solved = solve(scene_of(ball.request), ball.options);
    ++tally.outcomes[std::string(name_of(solved.record.status))];
    const auto found = solved.moves.find(MoveKind::rotate);
    tally.add(found == solved.moves.end() ? 0.0 : found->second);
    n_slides += solved.moves.count(MoveKind::translate) > 0 ? 1 : 0;
    n_wide += solved.record.contacts.size() >= 2 ? 1 : 0;
  }
  tally.outcomes["slid"] = n_slides;
  tally.outcomes["two contacts or more"] = n_wide;
  EXPECT_GT(n_slides, n_tested(100));
  EXPECT_GT(n_wide, n_tested(100));
  report(tally);
}

}  // namespace vrda::test::ball_test
