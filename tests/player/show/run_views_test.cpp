#include "show/run_watch.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"

namespace vrda::show::run_views_test {

/// Rounding of a handful of products.
constexpr double rounding = 1e-12;

TEST(RunViews, Tiles)
{
  const view::Viewport area{100, 50, 901, 703};
  for (std::size_t n = 1; n <= 16; ++n) {
    SCOPED_TRACE(n);
    const std::vector<view::Viewport> all = tiles(n, area);
    ASSERT_EQ(all.size(), n);
    int n_pixels = 0;
    for (std::size_t k = 0; k < n; ++k) {
      EXPECT_EQ(view::within(all[k], area), all[k]);
      for (std::size_t other = 0; other < k; ++other) EXPECT_EQ(view::within(all[k], all[other]).width, 0);
      n_pixels += all[k].width * all[k].height;
    }
    // Borders of at most two pixels, right of and below each tile.
    EXPECT_GE(n_pixels, area.width * area.height - static_cast<int>(n) * 2 * (area.width + area.height));
  }
}

/// A point in camera axes.
Eigen::Vector3d seen(const view::Camera& camera, const Eigen::Vector3d& p_world_mm)
{
  return camera.X_world_camera.inverse() * p_world_mm;
}

// A turned view is that of a turned and shifted joint.
TEST(RunViews, TurnedView)
{
  const std::vector<view::Viewport> area{{0, 0, 400, 300}};
  const std::vector<Eigen::Vector3d> corners{{-30, 0, 0}, {30, 0, 0}, {0, 30, 0},
                                             {0, -30, 0}, {0, 0, 30}, {0, 0, -30}};
  const Eigen::Vector3d turn_rad(rad_from_deg(20.0), rad_from_deg(-50.0), rad_from_deg(70.0));
  const Eigen::Vector3d shift_mm(3.0, -4.0, 5.0);
  const CameraView front = view::named_view("front", view::View::front, Side::right);
  const CameraView turned = view::turned_view("turned", turn_rad, shift_mm, Side::right);
  const CameraView unshifted = view::turned_view("turned", turn_rad, Eigen::Vector3d::Zero(), Side::right);
  const view::Camera shifted_camera = fitted_shots({turned}, area, corners, 1.0).front().camera;
  const view::Camera camera = fitted_shots({unshifted}, area, corners, 1.0).front().camera;
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

}  // namespace vrda::show::run_views_test
