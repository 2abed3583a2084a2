#include "geometry/generic_knee.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/units.hpp"
#include "model/frames.hpp"

namespace vrda::condyle_test {

TEST(Condyle, SupportSlopeAndRadiusMatchDifferences)
{
  constexpr double h_rad = 1e-4;
  constexpr double first_mm = 1e-6, second_mm = 1e-5;  // h^2 of the fourth derivative; rounding over h^2
  for (const geometry::Condyle& condyle : {geometry::medial_condyle(), geometry::lateral_condyle()}) {
    // Includes the spiral's end at 110 degrees.
    for (double angle_deg = -20.0; angle_deg <= 130.0; angle_deg += 7.3) {
      const double a = rad_from_deg(angle_deg);
      const double before = geometry::support(condyle, a - h_rad).value_mm,
                   after = geometry::support(condyle, a + h_rad).value_mm;
      const geometry::Support at = geometry::support(condyle, a);
      EXPECT_NEAR((after - before) / (2.0 * h_rad), at.slope_mm, first_mm);
      EXPECT_NEAR((after + before - 2.0 * at.value_mm) / (h_rad * h_rad) + at.value_mm,
                  geometry::radius_mm(condyle, a), second_mm);
    }
  }
}

TEST(Condyle, RadiusFallsFromDistalToPosteriorWithoutAJump)
{
  for (const geometry::Condyle& condyle : {geometry::medial_condyle(), geometry::lateral_condyle()}) {
    for (double angle_deg = 0.0; angle_deg < 130.0; angle_deg += 1.0) {
      const double here = geometry::radius_mm(condyle, rad_from_deg(angle_deg));
      const double next = geometry::radius_mm(condyle, rad_from_deg(angle_deg + 1.0));
      EXPECT_LE(next, here);
      EXPECT_LT(here - next, 1.0);  // the medial spiral decreases by at most 0.6 mm per degree
    }
  }
  EXPECT_NEAR(geometry::radius_mm(geometry::medial_condyle(), 0.0), 40.0, 1e-12);
}

TEST(Condyle, LowestPointOfTheTurnedCondyleIsItsSupport)
{
  const geometry::Condyle condyle = geometry::medial_condyle();
  for (double flexion_deg = 0.0; flexion_deg <= 90.0; flexion_deg += 15.0) {
    const double a = rad_from_deg(flexion_deg);
    const Eigen::Vector3d centre = rotation_z(a) * geometry::ball_centre_mm(condyle, a);
    const geometry::Support p = geometry::support(condyle, a);
    EXPECT_NEAR(centre.x(), -p.slope_mm, 1e-12);
    EXPECT_NEAR(centre.y() - condyle.coronal_radius_mm, -p.value_mm, 1e-12);
  }
}

TEST(CondyleSurface, DistanceMatchesAFineSearchOverTheOutline)
{
  std::mt19937 random(7);
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random()) / 4294967296.0;
  };
  int n_inside = 0, n_outside = 0;
  for (const geometry::Condyle& condyle : {geometry::medial_condyle(), geometry::lateral_condyle()}) {
    const geometry::CondyleSurface surface(condyle);
    for (int trial = 0; trial < 400; ++trial) {
      const Eigen::Vector3d p(uniform(-32, 36), uniform(-34, 26), condyle.z_mm + uniform(-25, 25));
      double wanted = 1e9;
      constexpr int n_steps = 20000;  // 2 micrometres along the outline; the error is its square / 2 mm
      for (int k = 0; k <= n_steps; ++k) {
        const double a = condyle.first_rad + (condyle.last_rad - condyle.first_rad) * k / n_steps;
        wanted =
            std::min(wanted, (p - geometry::ball_centre_mm(condyle, a)).norm() - condyle.coronal_radius_mm);
      }
      const double found = surface.signed_distance_mm(p);
      const bool is_near = wanted < 12.0;
      EXPECT_NEAR(is_near ? found : wanted, wanted, 1e-5);
      EXPECT_LE(found, wanted + 1e-5);  // far away: a lower bound
      n_inside += wanted < 0.0 ? 1 : 0;
      n_outside += wanted > 0.0 && is_near ? 1 : 0;
    }
  }
  EXPECT_GT(n_inside, 100);
  EXPECT_GT(n_outside, 100);
}

TEST(CondyleSurface, UndersideTouchesTheSurface)
{
  const geometry::Condyle condyle = geometry::lateral_condyle();
  const geometry::CondyleSurface surface(condyle);
  for (double x = -14.0; x <= 14.0; x += 3.5) {
    for (double dz = -14.0; dz <= 14.0; dz += 3.5) {
      const Eigen::Vector3d p(x, surface.underside_mm(x, condyle.z_mm + dz), condyle.z_mm + dz);
      EXPECT_NEAR(surface.signed_distance_mm(p), 0.0, 1e-11);
      EXPECT_GT(surface.signed_distance_mm(p - Eigen::Vector3d(0, 0.1, 0)), 0.0);
    }
  }
  const geometry::Support p = geometry::support(condyle, 0.0);
  EXPECT_NEAR(surface.underside_mm(-p.slope_mm, condyle.z_mm), -p.value_mm, 1e-11);
}

}  // namespace vrda::condyle_test
