#include "contact/narrow_phase.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "contact/triangles.hpp"
#include "support/triangle_distance.hpp"

namespace vrda::narrow_phase_test {

// Accuracy for triangles of 3 mm at any angle.
constexpr double promised_mm = 1e-12;

geometry::Corners shifted(geometry::Corners t, const Eigen::Vector3d& by)
{
  for (Eigen::Vector3d& p : t) p += by;
  return t;
}

TEST(NarrowPhase, AgreesWithTheTextbookDistance)
{
  test::Random random(11);
  contact::NarrowPhase narrow_phase;
  int n_apart = 0, n_overlapping = 0;
  for (int k = 0; k < 40000; ++k) {
    // A third each: anything, nearly parallel, coplanar within a micrometre and far from the origin.
    const double flatness = k % 3 == 0 ? 1.0 : k % 3 == 1 ? 1e-3 : 1e-7;
    const Eigen::Vector3d away = k % 2 == 0 ? Eigen::Vector3d(600, 500, 400) : Eigen::Vector3d::Zero();
    const geometry::Corners a = shifted(random.triangle(3, flatness), away);
    const geometry::Corners b =
        shifted(random.triangle(3, flatness), away + 0.01 * random.unit() * Eigen::Vector3d::UnitY());
    const contact::TriangleDistance measured = narrow_phase.measure(a, b);
    const double expected = test::triangle_distance_mm(a, b);
    EXPECT_NEAR(std::max(0.0, measured.distance_mm), expected, promised_mm);
    EXPECT_EQ(measured.is_overlapping, expected <= 0.0) << expected;
    n_apart += measured.is_overlapping ? 0 : 1;
    n_overlapping += measured.is_overlapping ? 1 : 0;
  }
  EXPECT_GT(n_apart, 5000);
  EXPECT_GT(n_overlapping, 1000);
}

// A pyramid's corner 0.0008 mm from the edge between two faces of its sink: Bullet's GJK ended at a distance
// of 6.4 mm.
TEST(NarrowPhase, ACornerAtTheMiddleOfAnEdge)
{
  const geometry::Corners sink{
      Eigen::Vector3d(-0x1.d440a4ca4e34p+4, -0x1.500d0dfb0d41fp+4, -0x1.d440a4ca4e34p+3),
      Eigen::Vector3d(-0x1.d440a4ca4e34p+3, -0x1.500d0dfb0d41fp+3, 0.0),
      Eigen::Vector3d(-0x1.d440a4ca4e34p+4, -0x1.500d0dfb0d41fp+4, 0.0)};
  const geometry::Corners pyramid{
      Eigen::Vector3d(-0x1.b6c864621c28ap+4, -0x1.3aeadd38ec514p+4, -0x1p-49),
      Eigen::Vector3d(-0x1.49164b49951e7p+4, -0x1.3aeadd38ec514p+4, 0x1.b6c864621c288p+2),
      Eigen::Vector3d(-0x1.b6c864621c28ap+3, -0x1.972a7aa4cc824p+3, -0x1p-50)};
  constexpr double near_contact_mm = 1e-9;
  contact::NarrowPhase narrow_phase;
  EXPECT_NEAR(narrow_phase.measure(sink, pyramid).distance_mm, test::triangle_distance_mm(sink, pyramid),
              near_contact_mm);
  // The same shape in other sizes, whose last digits differ.
  test::Random random(19);
  for (int k = 0; k < 20000; ++k) {
    const double factor = 1.0 + 0.5 * random.unit();
    geometry::Corners a = sink, b = pyramid;
    for (geometry::Corners* t : {&a, &b})
      for (Eigen::Vector3d& p : *t) p *= factor;
    ASSERT_NEAR(narrow_phase.measure(a, b).distance_mm, test::triangle_distance_mm(a, b), near_contact_mm)
        << factor;
    ASSERT_NEAR(narrow_phase.measure(b, a).distance_mm, test::triangle_distance_mm(a, b), near_contact_mm)
        << factor;
  }
}

TEST(NarrowPhase, DistinguishesAGapOfTenNanometresFromAnOverlap)
{
  contact::NarrowPhase narrow_phase;
  const geometry::Corners face{Eigen::Vector3d(-2, 0, -2), Eigen::Vector3d(0, 0, 3),
                               Eigen::Vector3d(2, 0, -2)};
  for (const double gap_mm : {1e-2, 1e-4, 1e-6, 1e-5}) {
    const geometry::Corners above{Eigen::Vector3d(0, gap_mm, 0), Eigen::Vector3d(1, 2, 0),
                                  Eigen::Vector3d(0, 2, 1)};
    EXPECT_FALSE(narrow_phase.measure(face, above).is_overlapping);
    EXPECT_NEAR(narrow_phase.measure(face, above).distance_mm, gap_mm, promised_mm);
    const geometry::Corners through = shifted(above, {0, -2 * gap_mm, 0});
    EXPECT_TRUE(narrow_phase.measure(face, through).is_overlapping);
  }
}

TEST(NarrowPhase, TheCheapTestNeverPartsWhatIsWithinTheBand)
{
  test::Random random(13);
  int n_separated = 0;
  for (int k = 0; k < 20000; ++k) {
    const geometry::Corners a = random.triangle(3, 0.2),
                            b = shifted(random.triangle(3, 0.2), {0, random.unit(), 0});
    if (!contact::is_certainly_separated(a, b, 0.1)) continue;
    ++n_separated;
    EXPECT_GT(test::triangle_distance_mm(a, b), 0.1);
  }
  EXPECT_GT(n_separated, 2000);
}

// A hundred times the rounding of coordinates up to 100 mm.
constexpr double rounding_mm = 1e-12;

geometry::Corners raised(geometry::Corners t, double by_mm)
{
  for (Eigen::Vector3d& p : t) p.y() += by_mm;
  return t;
}

// Overlapping pairs, and the height by which the second must rise to touch the first from above.
struct Pair {
  geometry::Corners a, b;
  double touch_mm = 0.0;
};

Pair touching_pair(test::Random& random, double size_mm, double flatness)
{
  Pair pair;
  do {
    pair.a = random.triangle(size_mm, flatness);
    pair.b = random.triangle(1.0, flatness);
  } while (test::triangle_distance_mm(pair.a, pair.b) > 0.0);
  double low = 0.0, high = 2.0 * (size_mm + 1.0) * flatness;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (test::triangle_distance_mm(pair.a, raised(pair.b, middle)) > 0.0 ? high : low) = middle;
  }
  pair.touch_mm = high;
  return pair;
}

// From random slopes to nearly parallel, where GJK stops early.
constexpr double flatnesses[] = {1.0, 1e-2, 1e-5, 1e-7};
constexpr double sizes_mm[] = {0.1, 1.0, 3.0, 40.0};

// Points on the triangles at the textbook's distance are closest points, unique or not: on either side of the
// distance from which pairs are backed off, at every size.
TEST(NarrowPhase, FindsClosestPoints)
{
  constexpr double agreed_mm = 1e-9;
  test::Random random(34);
  contact::NarrowPhase narrow_phase;
  for (const double size_mm : sizes_mm) {
    for (int k = 0; k < 1000; ++k) {
      const Pair pair = touching_pair(random, size_mm, 1.0);
      for (const double above_mm : {1e-9, 1e-7, 1e-5, 9e-4, 2e-3, 0.05, 1.0}) {
        const geometry::Corners b = raised(pair.b, pair.touch_mm + above_mm);
        const double expected_mm = test::triangle_distance_mm(pair.a, b);
        const contact::TriangleDistance found = narrow_phase.measure(pair.a, b);
        ASSERT_FALSE(found.is_overlapping);
        EXPECT_FALSE(narrow_phase.overlap(pair.a, b));
        EXPECT_NEAR(found.distance_mm, expected_mm, agreed_mm);
        EXPECT_NEAR((found.p_moving_mm - found.p_reference_mm).norm(), expected_mm, agreed_mm);
        EXPECT_LE(test::outside_mm(pair.a, found.p_reference_mm), agreed_mm);
        EXPECT_LE(test::outside_mm(b, found.p_moving_mm), agreed_mm);
      }
    }
  }
}

TEST(NarrowPhase, OverlapEndsAtTheTouch)
{
  test::Random random(32);
  contact::NarrowPhase narrow_phase;
  int n_overlapping = 0, n_apart = 0;
  for (const double flatness : flatnesses) {
    for (const double size_mm : sizes_mm) {
      for (int k = 0; k < 100; ++k) {
        const Pair pair = touching_pair(random, size_mm, flatness);
        for (const double above_mm : {-1e-6, -1e-7, -1e-9, 1e-9, 1e-7, 1e-6}) {
          const geometry::Corners b = raised(pair.b, pair.touch_mm + above_mm);
          const double expected_mm = test::triangle_distance_mm(pair.a, b);
          // A triangle raised or lowered by more than its thickness may be free on either side of the
          // contact.
          const bool is_overlapping = expected_mm <= 0.0;
          EXPECT_EQ(narrow_phase.measure(pair.a, b).is_overlapping, is_overlapping) << expected_mm;
          EXPECT_EQ(narrow_phase.overlap(pair.a, b), is_overlapping) << expected_mm;
          (is_overlapping ? n_overlapping : n_apart) += 1;
        }
      }
    }
  }
  EXPECT_GT(n_overlapping, 3000);
  EXPECT_GT(n_apart, 4000);
}

TEST(EstimatedClosestPoints, OfTrianglesWithoutAnEdgeOrAnAreaAreEmptyOrRight)
{
  const geometry::Corners face{Eigen::Vector3d(-2, 0, -2), Eigen::Vector3d(-2, 0, 2),
                               Eigen::Vector3d(3, 0, 0)};
  const Eigen::Vector3d p(0, 0.5, 0), q(0.5, 0.75, 0);
  for (const geometry::Corners& degenerate :
       {geometry::Corners{p, p, p}, geometry::Corners{p, q, q}, geometry::Corners{p, 0.5 * (p + q), q}}) {
    const std::optional<contact::TriangleDistance> found = contact::closest_points(face, degenerate);
    EXPECT_NEAR(found ? found->distance_mm : 0.5, 0.5, rounding_mm);
  }
}

}  // namespace vrda::narrow_phase_test
