#include "analysis/score.hpp"

#include <gtest/gtest.h>

#include "analysis/moving_joint.hpp"

namespace vrda::analysis::rigid_alignment_test {

// Points of some 100 mm with a rounding of 1e-14 each, through a fit with a condition number of some 1e3.
constexpr double exact = 1e-9;
const Eigen::Vector3d centre_mm(3, -8, 5);

std::vector<Pose> moving_poses(int n)
{
  std::vector<Pose> poses;
  for (int k = 0; k < n; ++k) {
    poses.push_back(right_sided_pose(test::moving_coordinates(k, n),
                                     {Side::right, centre_mm, Translations::rotation_centre}));
  }
  return poses;
}

std::vector<Pose> transformed(const Pose& X_reference, const std::vector<Pose>& poses, const Pose& X_moving)
{
  std::vector<Pose> result;
  for (const Pose& X : poses) result.push_back(X_reference * X * X_moving);
  return result;
}

double largest_difference(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

TEST(RigidAlignment, UndoesARigidTransformOfEachBody)
{
  const std::vector<Pose> found = moving_poses(40);
  struct Row {
    Pose X_reference, X_moving;
  };
  for (const Row& row : {Row{Pose::Identity(), Pose::Identity()},
                         Row{test::rigid_transform(0.02, -0.03, 0.01, {1, -2, 0.5}), Pose::Identity()},
                         Row{Pose::Identity(), test::rigid_transform(0.1, 0.2, -0.1, {-5, 1, 3})},
                         Row{test::rigid_transform(2.5, -1.0, 3.0, {400, -70, 20}),
                             test::rigid_transform(-1.7, 0.8, 1.2, {-30, 90, -250})}}) {
    const std::vector<Pose> measured = transformed(row.X_reference, found, row.X_moving);
    const RigidAlignment a = rigid_alignment(found, measured, centre_mm);
    EXPECT_TRUE(a.is_converged);
    EXPECT_EQ(a.n_determined, 12);
    EXPECT_LT(a.rms_mm, exact);
    EXPECT_LT(largest_difference(a.X_reference, row.X_reference), exact);
    EXPECT_LT(largest_difference(a.X_moving, row.X_moving), exact);
  }
}

TEST(RigidAlignment, OfAHingeLeavesItsAxisUndetermined)
{
  // the reference may turn about the hinge and slide along it if the moving object undoes both
  std::vector<Pose> found;
  for (int k = 0; k < 20; ++k) found.push_back(test::rigid_transform(0, 0, -0.05 * k, {0, 0, 0}));
  const Pose X_reference = test::rigid_transform(0.3, 0.1, 0.2, {4, 5, 6});
  const RigidAlignment a =
      rigid_alignment(found, transformed(X_reference, found, Pose::Identity()), centre_mm);
  EXPECT_TRUE(a.is_converged);
  EXPECT_EQ(a.n_determined, 10);
  EXPECT_LT(a.rms_mm, exact);
}

TEST(RigidAlignment, OfAShortNoisyMotionClaimsNoLargeRotation)
{
  // Seven degrees of flexion; varus and internal rotation are small and found with the wrong sign. Half a
  // turn of both frames about the axis of flexion mends the sign and leaves less, but only as much as the
  // noise.
  std::vector<Pose> found, measured;
  for (int k = 0; k < 30; ++k) {
    const double flexion_rad = 0.12 * sine(0.2 * k), small_rad = 0.01 * sine(1.3 * k);
    found.push_back(test::rigid_transform(small_rad, -small_rad, -flexion_rad, {0, 0, 0}));
    measured.push_back(test::rigid_transform(-small_rad, small_rad, -flexion_rad, {1, 0, 0}));
    measured.back().translation() += 0.5 * Eigen::Vector3d(sine(2.1 * k), sine(3.7 * k), sine(5.3 * k));
  }
  const RigidAlignment a = rigid_alignment(found, measured, {0, 0, 0});
  EXPECT_TRUE(a.is_converged);
  EXPECT_LT(a.n_determined, 12);
  EXPECT_GT(a.X_reference.linear().trace(), 2.9);  // below 20 degrees
  EXPECT_GT(a.X_moving.linear().trace(), 2.9);
  EXPECT_NEAR((a.X_reference * a.X_moving).translation().x(), 1.0, 0.2);
}

TEST(RigidAlignment, LeavesWhatNoTransformExplains)
{
  // noise of known size: the distance left is at most that without alignment, and no small change of either
  // transform brings the poses nearer
  const std::vector<Pose> found = moving_poses(40);
  std::vector<Pose> measured = found;
  for (std::size_t k = 0; k < measured.size(); ++k) measured[k].translation().x() += k % 2 == 0 ? 0.5 : -0.5;
  const RigidAlignment a = rigid_alignment(found, measured, centre_mm);
  EXPECT_TRUE(a.is_converged);
  EXPECT_GT(a.rms_mm, 0.4);
  EXPECT_LE(a.rms_mm, 0.5);
  const RigidAlignment again =
      rigid_alignment(transformed(a.X_reference, found, a.X_moving), measured, centre_mm);
  EXPECT_NEAR(again.rms_mm, a.rms_mm, exact);
  // Of a quadratic with a rounding of 1e-16: the minimum is known to its square root.
  EXPECT_LT(largest_difference(again.X_reference, Pose::Identity()), 1e-6);
  EXPECT_LT(largest_difference(again.X_moving, Pose::Identity()), 1e-6);
}

}  // namespace vrda::analysis::rigid_alignment_test
