#include "model/frames.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "support/meshes.hpp"

namespace vrda::frames_test {

constexpr double rounding = 1e-12;  // mm or rad, coordinates of hundreds of mm

SolverFrame far_frame(Side side, const Eigen::Vector3d& delta)
{
  return {side, {430.0, 510.0, side == Side::left ? -75.0 : 75.0}, delta};
}

TEST(Frames, shortest_rotation)
{
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  for (const Eigen::Vector3d& from :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(1, 0, 0),
        Eigen::Vector3d(Eigen::Vector3d(1, -2, 0.5).normalized())}) {
    const Eigen::Matrix3d R = shortest_rotation(from, y);
    EXPECT_LT((R * from - y).norm(), rounding);
    EXPECT_NEAR(R.determinant(), 1.0, rounding);
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), rounding);
  }
}

TEST(Frames, stored_pose)
{
  // A moving vertex must have the same position relative to the reference in S and through the stored pose.
  const Attitude attitude{0.7, -0.1};
  const MovingPose pose{{1.5, -20.0, 2.5}, 0.2};
  for (const Side side : {Side::right, Side::left}) {
    for (const Eigen::Vector3d& delta :
         {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(Eigen::Vector3d(0.1, 1, -0.3).normalized())}) {
      const SolverFrame frame = far_frame(side, delta);
      Mesh stored = test::box({440, 500, 70}, {10, 20, 30});
      const Pose X = X_reference_moving(frame, attitude, pose);
      const Mesh seen = solver_mesh(transformed(stored, X), frame);
      const Mesh moving = solver_mesh(stored, frame);
      for (Eigen::Index v = 0; v < seen.vertices_mm.rows(); ++v) {
        const Eigen::Vector3d from_reference =
            reference_rotation(attitude) * Eigen::Vector3d(seen.vertices_mm.row(v));
        const Eigen::Vector3d from_moving = pose_of(pose) * Eigen::Vector3d(moving.vertices_mm.row(v));
        EXPECT_LT((from_reference - from_moving).norm(), 1e-11);
      }
    }
  }
}

TEST(Frames, grood_suntay)
{
  const double f = 0.9, v = 0.12, theta = -0.3;
  const Pose X = X_reference_moving({}, {f, v}, {{0, 0, 0}, theta});
  EXPECT_LT((X.linear() - rotation_z(-f) * rotation_x(v) * rotation_y(theta)).norm(), rounding);
}

TEST(Frames, world_translation)
{
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame = far_frame(side, Eigen::Vector3d(0.2, 0.9, 0.1).normalized());
    const MovingPose pose{{1, 2, 3}, 0.0};
    EXPECT_LT((solver_translation_mm(frame, world_translation_mm(frame, pose)) - pose.translation_mm).norm(),
              rounding);
  }
}

TEST(Clinical, attitude_and_theta)
{
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame = far_frame(side, {0, 1, 0});
    const Pose X =
        X_reference_moving(frame, {rad_from_deg(75), rad_from_deg(-6)}, {{0, 0, 0}, rad_from_deg(11)});
    const ClinicalCoordinates clinical = clinical_coordinates(X, side, frame.rotation_centre_mm);
    EXPECT_NEAR(deg_from_rad(clinical.flexion_rad), 75, 1e-9);
    EXPECT_NEAR(deg_from_rad(clinical.varus_rad), -6, 1e-9);
    EXPECT_NEAR(deg_from_rad(clinical.internal_rotation_rad), 11, 1e-9);
    EXPECT_NEAR(clinical.anterior_mm, 0, 1e-9);
  }
}

TEST(Frames, solver_position)
{
  for (const Side side : {Side::right, Side::left}) {
    for (const Eigen::Vector3d& delta : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(-1, 0, 0),
                                         Eigen::Vector3d(Eigen::Vector3d(0.3, 1, -0.2).normalized())}) {
      for (const double flexion_rad : {-2.9, 0.0, 1.1, 3.0}) {
        const SolverFrame frame = far_frame(side, delta);
        const Attitude attitude{flexion_rad, 0.07};
        const MovingPose pose{{1.25, -3.5, 0.75}, -0.21};
        const SolverPosition found = solver_position(frame, X_reference_moving(frame, attitude, pose));
        EXPECT_NEAR(found.attitude.flexion_rad, flexion_rad, rounding);
        EXPECT_NEAR(found.attitude.varus_rad, 0.07, rounding);
        EXPECT_NEAR(found.pose.theta_rad, -0.21, rounding);
        EXPECT_LT((found.pose.translation_mm - pose.translation_mm).norm(), rounding);
      }
    }
  }
}

TEST(Clinical, translations)
{
  Pose X = Pose::Identity();
  X.translation() << 1, 2, 3;
  const ClinicalCoordinates right = clinical_coordinates(X, Side::right, {0, 0, 0});
  EXPECT_NEAR(right.anterior_mm, 1, rounding);
  EXPECT_NEAR(right.proximal_mm, 2, rounding);
  EXPECT_NEAR(right.lateral_mm, 3, rounding);
  X.translation().z() = -3;
  EXPECT_NEAR(clinical_coordinates(X, Side::left, {0, 0, 0}).lateral_mm, 3, rounding);
}

TEST(Clinical, mirrored_pose)
{
  const MovingPose pose{{1.25, -3.5, 0.75}, 0.21};
  const Attitude attitude{1.1, 0.07};
  const SolverFrame right = far_frame(Side::right, {0, 1, 0});
  const SolverFrame left = far_frame(Side::left, {0, 1, 0});
  const ClinicalCoordinates r =
      clinical_coordinates(X_reference_moving(right, attitude, pose), Side::right, right.rotation_centre_mm);
  const ClinicalCoordinates l =
      clinical_coordinates(X_reference_moving(left, attitude, pose), Side::left, left.rotation_centre_mm);
  EXPECT_EQ(r.flexion_rad, l.flexion_rad);
  EXPECT_EQ(r.varus_rad, l.varus_rad);
  EXPECT_EQ(r.internal_rotation_rad, l.internal_rotation_rad);
  EXPECT_EQ(r.anterior_mm, l.anterior_mm);
  EXPECT_EQ(r.proximal_mm, l.proximal_mm);
  EXPECT_EQ(r.lateral_mm, l.lateral_mm);
}

}  // namespace vrda::frames_test
