#include "job/auto_frame.hpp"

#include <gtest/gtest.h>

#include "support/meshes.hpp"

namespace vrda::condyles_test {

Mesh moved(const Mesh& mesh, const Eigen::Vector3d& by_mm)
{
  Pose X_to_from = Pose::Identity();
  X_to_from.translation() = by_mm;
  return transformed(mesh, X_to_from);
}

TEST(Condyles, two_balls)
{
  const Eigen::Vector3d left_mm(420, 511, 600), right_mm(424, 514, 650);
  Mesh femur = moved(test::ball(20, 48, 96), left_mm);
  append(femur, moved(test::ball(23, 48, 96), right_mm));
  const std::optional<job::CondyleSpheres> spheres = job::condyle_spheres(femur);
  ASSERT_TRUE(spheres.has_value());
  // Face centres are inside the sphere by its sagitta, at most r (pi / 48)^2 / 2 = 0.05 mm.
  constexpr double sagitta_mm = 0.05;
  EXPECT_LT((spheres->left.centre_mm - left_mm).norm(), sagitta_mm);
  EXPECT_LT((spheres->right.centre_mm - right_mm).norm(), sagitta_mm);
  EXPECT_NEAR(spheres->left.radius_mm, 20.0, sagitta_mm);
  EXPECT_NEAR(spheres->right.radius_mm, 23.0, sagitta_mm);
}

TEST(Condyles, box)
{
  EXPECT_FALSE(job::condyle_spheres(test::box({0, 0, 0}, {60, 60, 80})).has_value());
  EXPECT_FALSE(job::condyle_spheres(Mesh{}).has_value());
}

}  // namespace vrda::condyles_test
