#include "contact/narrow_phase.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "contact/random_triangles.hpp"
#include "support/triangle_distance.hpp"

namespace vrda::narrow_phase_test {

// Distances within 1e-3 mm are exact; Bullet's, further off, are this good for triangles of 3 mm however
// parallel.
constexpr double promised_mm = 1e-8;

Corners shifted(Corners t, const Eigen::Vector3d& by)
{
  for (Eigen::Vector3d& p : t) p += by;
  return t;
}

TEST(NarrowPhase, AgreesWithTheTextbookDistance)
{
  test::Random random(11);
  NarrowPhase narrow_phase;
  int n_apart = 0, n_overlapping = 0;
  for (int k = 0; k < 40000; ++k) {
    // A third each: anything, nearly parallel, coplanar within a micrometre and far from the origin.
    const double flatness = k % 3 == 0 ? 1.0 : k % 3 == 1 ? 1e-3 : 1e-7;
    const Eigen::Vector3d away = k % 2 == 0 ? Eigen::Vector3d(600, 500, 400) : Eigen::Vector3d::Zero();
    const Corners a = shifted(random.triangle(3, flatness), away);
    const Corners b =
        shifted(random.triangle(3, flatness), away + 0.01 * random.unit() * Eigen::Vector3d::UnitY());
    const TriangleDistance measured = narrow_phase.measure(a, b);
    const double expected = test::triangle_distance_mm(a, b);
    EXPECT_NEAR(measured.distance_mm, expected, promised_mm);
    EXPECT_EQ(measured.is_overlapping, expected <= 0.0) << expected;
    n_apart += measured.is_overlapping ? 0 : 1;
    n_overlapping += measured.is_overlapping ? 1 : 0;
  }
  EXPECT_GT(n_apart, 5000);
  EXPECT_GT(n_overlapping, 1000);
}

TEST(NarrowPhase, PointsLieOnTheTrianglesAtTheDistance)
{
  test::Random random(12);
  NarrowPhase narrow_phase;
  int n_apart = 0;
  for (int k = 0; k < 5000; ++k) {
    const Corners a = random.triangle(3, 1), b = shifted(random.triangle(3, 1), {0, 4, 0});
    const TriangleDistance measured = narrow_phase.measure(a, b);
    if (measured.is_overlapping) continue;
    ++n_apart;
    EXPECT_NEAR((measured.p_reference_mm - measured.p_moving_mm).norm(), measured.distance_mm, promised_mm);
    const Eigen::Vector3d n = (a[1] - a[0]).cross(a[2] - a[0]).normalized();
    EXPECT_NEAR(n.dot(measured.p_reference_mm - a[0]), 0.0, promised_mm);
  }
  EXPECT_GT(n_apart, 4000);
}

TEST(NarrowPhase, TellsAGapOfTenNanometresFromAnOverlap)
{
  NarrowPhase narrow_phase;
  const Corners face{Eigen::Vector3d(-2, 0, -2), Eigen::Vector3d(0, 0, 3), Eigen::Vector3d(2, 0, -2)};
  for (const double gap_mm : {1e-2, 1e-4, 1e-6, 1e-5}) {
    const Corners above{Eigen::Vector3d(0, gap_mm, 0), Eigen::Vector3d(1, 2, 0), Eigen::Vector3d(0, 2, 1)};
    EXPECT_FALSE(narrow_phase.measure(face, above).is_overlapping);
    EXPECT_NEAR(narrow_phase.measure(face, above).distance_mm, gap_mm, promised_mm);
    const Corners through = shifted(above, {0, -2 * gap_mm, 0});
    EXPECT_TRUE(narrow_phase.measure(face, through).is_overlapping);
  }
}

TEST(NarrowPhase, TheCheapTestNeverPartsWhatIsWithinTheBand)
{
  test::Random random(13);
  int n_separated = 0;
  for (int k = 0; k < 20000; ++k) {
    const Corners a = random.triangle(3, 0.2), b = shifted(random.triangle(3, 0.2), {0, random.unit(), 0});
    if (!is_surely_apart(a, b, 0.1)) continue;
    ++n_separated;
    EXPECT_GT(test::triangle_distance_mm(a, b), 0.1);
  }
  EXPECT_GT(n_separated, 2000);
}

}  // namespace vrda::narrow_phase_test
