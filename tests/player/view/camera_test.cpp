#include "view/camera.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"
#include "support/models.hpp"

namespace vrda::view::camera_test {

constexpr double rounding = 1e-10;  // of image coordinates of order one

/// Normalised device coordinates of a point: x and y on [-1, 1], z in the depth range.
Eigen::Vector3d projected(const Camera& camera, const Eigen::Vector3d& p_world_mm)
{
  const Eigen::Vector3d p_camera = camera.X_world_camera.inverse() * p_world_mm;
  const Eigen::Vector4d clip = projection(camera) * p_camera.homogeneous();
  return clip.hnormalized();
}

Camera fitted(const std::vector<Eigen::Vector3d>& points, const Eigen::Matrix3d& R,
              const FrameOptions& options = {})
{
  CameraFit fit(R, options);
  fit.include(points);
  return fit.camera();
}

std::vector<Eigen::Vector3d> box_corners(const Eigen::Vector3d& low, const Eigen::Vector3d& high)
{
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(8);
  for (int corner = 0; corner < 8; ++corner) {
    corners.emplace_back(corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y(),
                         corner & 4 ? high.z() : low.z());
  }
  return corners;
}

// Every view has the whole box in the filled part and fills it.
TEST(Camera, FitFillsThePicture)
{
  const std::vector<Eigen::Vector3d> corners = box_corners({-30, -70, -45}, {25, 40, 38});
  for (const std::string& name : view_names()) {
    for (const double aspect : {0.6, 4.0 / 3.0, 3.0}) {
      SCOPED_TRACE(name + " " + std::to_string(aspect));
      FrameOptions options;
      options.aspect = aspect;
      options.fill_fraction = 0.8;
      const Camera camera = fitted(corners, view_rotation(*view_named(name), Side::right), options);
      Eigen::Vector2d low(9, 9), high(-9, -9);
      for (const Eigen::Vector3d& corner : corners) {
        low = low.cwiseMin(projected(camera, corner).head<2>());
        high = high.cwiseMax(projected(camera, corner).head<2>());
      }
      EXPECT_GE(low.minCoeff(), -0.8 - rounding);
      EXPECT_LE(high.maxCoeff(), 0.8 + rounding);
      EXPECT_NEAR(low.minCoeff(), -0.8, rounding);
      EXPECT_NEAR(high.maxCoeff(), 0.8, rounding);
      // Both borders of one direction are touched.
      EXPECT_NEAR((high - low).maxCoeff(), 1.6, rounding);
    }
  }
}

TEST(Camera, FitOverPoses)
{
  const std::vector<Eigen::Vector3d> first = box_corners({-1, -2, -3}, {1, 2, 3});
  const std::vector<Eigen::Vector3d> second = box_corners({-5, 0, 0}, {0, 1, 1});
  std::vector<Eigen::Vector3d> both = first;
  both.insert(both.end(), second.begin(), second.end());
  const Eigen::Matrix3d R = view_rotation(View::oblique, Side::left);
  CameraFit fit(R);
  fit.include(first);
  fit.include(second);
  EXPECT_EQ(fit.camera().X_world_camera.matrix(), fitted(both, R).X_world_camera.matrix());
  EXPECT_THROW(CameraFit(R).camera(), InternalError);
}

TEST(Camera, NamedViews)
{
  struct Row {
    View view;
    Side side;
    Eigen::Vector3d towards_viewer, right_of_picture;
  };
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  for (const Row& row : {Row{View::front, Side::right, x, -z}, Row{View::back, Side::right, -x, z},
                         Row{View::right, Side::left, z, x}, Row{View::left, Side::left, -z, -x},
                         Row{View::lateral, Side::right, z, x}, Row{View::lateral, Side::left, -z, -x},
                         Row{View::medial, Side::right, -z, -x}, Row{View::medial, Side::left, z, x},
                         Row{View::top, Side::right, y, z}}) {
    const Eigen::Matrix3d R = view_rotation(row.view, row.side);
    EXPECT_LT((R.col(2) - row.towards_viewer).norm(), rounding);
    EXPECT_LT((R.col(0) - row.right_of_picture).norm(), rounding);
    EXPECT_NEAR(R.determinant(), 1.0, rounding);
  }
  // The oblique view shows front, lateral side and top of both knees.
  EXPECT_GT(view_rotation(View::oblique, Side::right).col(2).minCoeff(), 0.2);
  EXPECT_LT(view_rotation(View::oblique, Side::left)(2, 2), -0.2);
  // The inverted view shows front, lateral side and underside, and image up is world down.
  const Eigen::Matrix3d inverted = view_rotation(View::inverted, Side::right);
  EXPECT_GT(inverted(0, 2), 0.2);
  EXPECT_LT(inverted(1, 2), -0.2);
  EXPECT_GT(inverted(2, 2), 0.2);
  EXPECT_LT(inverted(1, 1), -0.5);
  EXPECT_GT(view_rotation(View::inverted, Side::left).determinant(), 0.0);
}

TEST(Camera, DepthRange)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  place(scene, frames_of(store::Motion(model, "raw").at({rad_from_deg(50.0), 0.0})));
  const std::vector<Eigen::Vector3d> points = points_within(scene, {});
  const Camera camera = with_depth_range(fitted(points, view_rotation(View::oblique, Side::right)), scene);
  EXPECT_GT(camera.near_mm, 0.0);
  for (const Eigen::Vector3d& p_mm : points) {
    const Eigen::Vector3d p = projected(camera, p_mm);
    EXPECT_LE(std::abs(p.z()), 1.0);
  }
}

// The depth range stays sane with things behind the camera.
TEST(Camera, DepthRangeBehindTheCamera)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  const Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  const Camera inside = with_depth_range(Camera{}, scene);  // at the middle of the ball
  EXPECT_GT(inside.near_mm, 0.0);
  EXPECT_GT(inside.far_mm, inside.near_mm);
}

}  // namespace vrda::view::camera_test
