#include "show/run_watch.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"

namespace vrda::run_views_test {

/// Rounding of a handful of products.
constexpr double rounding = 1e-12;

TEST(RunViews, TilesCoverTheAreaWithoutOverlap)
{
  const view::Viewport area{100, 50, 901, 703};
  for (std::size_t n = 1; n <= 16; ++n) {
    SCOPED_TRACE(n);
    const std::vector<view::Viewport> all = show::tiles(n, area);
    ASSERT_EQ(all.size(), n);
    std::vector<int> n_covering(static_cast<std::size_t>(area.width * area.height), 0);
    int n_pixels = 0;
    for (const view::Viewport& tile : all) {
      for (int y = tile.y; y < tile.y + tile.height; ++y) {
        for (int x = tile.x; x < tile.x + tile.width; ++x) {
          ASSERT_TRUE(x >= 100 && x < 1001 && y >= 50 && y < 753);
          ++n_covering[static_cast<std::size_t>((y - 50) * area.width + x - 100)];
          ++n_pixels;
        }
      }
    }
    EXPECT_EQ(*std::ranges::max_element(n_covering), 1);
    // Borders of at most two pixels, right of and below each tile.
    EXPECT_GE(n_pixels, area.width * area.height - static_cast<int>(n) * 2 * (area.width + area.height));
  }
}

TEST(RunViews, FourTilesAreTwoByTwo)
{
  const std::vector<view::Viewport> all = show::tiles(4, {0, 0, 800, 600});
  EXPECT_EQ(all[1].x, 400);
  EXPECT_EQ(all[1].y, 0);
  EXPECT_EQ(all[2].x, 0);
  EXPECT_EQ(all[2].y, 300);
}

/// A point in camera axes.
Eigen::Vector3d seen(const view::Camera& camera, const Eigen::Vector3d& p_world_mm)
{
  return camera.X_world_camera.inverse() * p_world_mm;
}

TEST(RunViews, ATurnedViewIsThatOfATurnedAndShiftedJoint)
{
  const std::vector<view::Viewport> area{{0, 0, 400, 300}};
  const std::vector<Eigen::Vector3d> corners{{-30, 0, 0}, {30, 0, 0}, {0, 30, 0},
                                             {0, -30, 0}, {0, 0, 30}, {0, 0, -30}};
  const Eigen::Vector3d turn_rad(rad_from_deg(20.0), rad_from_deg(-50.0), rad_from_deg(70.0));
  const Eigen::Vector3d shift_mm(3.0, -4.0, 5.0);
  const show::CameraView front = view::named_view("front", view::View::front, Side::right);
  const show::CameraView turned = view::turned_view("turned", turn_rad, shift_mm, Side::right);
  const show::CameraView unshifted =
      view::turned_view("turned", turn_rad, Eigen::Vector3d::Zero(), Side::right);
  const view::Camera shifted_camera = show::fitted_shots({turned}, area, corners, 1.0).front().camera;
  const view::Camera camera = show::fitted_shots({unshifted}, area, corners, 1.0).front().camera;
  // In the axes of the front view: X to the subject's left, Y up, Z forward.
  const Eigen::Matrix3d R_front = front.R_world_camera;
  const Eigen::Matrix3d R_turn =
      rotation_z(turn_rad.z()) * rotation_y(turn_rad.y()) * rotation_x(turn_rad.x());
  for (const Eigen::Vector3d& p_mm : corners) {
    const Eigen::Vector3d about_origin = seen(camera, p_mm) - seen(camera, Eigen::Vector3d::Zero());
    EXPECT_LT((about_origin - R_turn * (R_front.transpose() * p_mm)).norm(), 30.0 * rounding);
    EXPECT_LT((seen(shifted_camera, p_mm) - seen(camera, p_mm) - shift_mm).norm(), 1000.0 * rounding);
  }
}

TEST(RunViews, ZoomMakesThePictureLarger)
{
  const std::vector<view::Viewport> area{{0, 0, 400, 300}};
  const std::vector<Eigen::Vector3d> corners{{-30, 0, 0}, {30, 0, 0}, {0, 30, 0}};
  const show::CameraView front = view::named_view("front", view::View::front, Side::left);
  const view::Camera plain = show::fitted_shots({front}, area, corners, 1.0).front().camera;
  const view::Camera near = show::fitted_shots({front}, area, corners, 2.0).front().camera;
  EXPECT_NEAR(near.half_height_tangent, 0.5 * plain.half_height_tangent, rounding);
}

}  // namespace vrda::run_views_test
