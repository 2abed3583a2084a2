#include <gtest/gtest.h>

#include <cmath>

#include "player/view/pictures.hpp"
#include "support/meshes.hpp"

namespace vrda::view::occlusion_test {

using namespace test;

constexpr int width = 320, height = 240;
constexpr double mm_per_pixel = 2.0 * 25.0 / height;  // at the distance of camera_at(100)

/// A wall of 100 mm that faces the camera, and a ball of 10 mm in front of it at the height of the picture's
/// middle, `gap_mm` away.
Scene wall_with_ball(double gap_mm)
{
  Scene scene = dark_scene();
  add(scene, facing_sheet(100.0), plain({0.5F, 0.5F, 0.5F}));
  add(scene, ball(10.0, 32, 64), plain({0.5F, 0.5F, 0.5F}), {0, 0, 10.0 + gap_mm});
  return scene;
}

int green(const Image& image, double x_mm)
{
  return at(image, static_cast<int>(std::lround(width / 2 + x_mm / mm_per_pixel)), height / 2)[1];
}

TEST(Occlusion, FreeBall)
{
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    Scene scene = wall_with_ball(40.0);
    const Image plain = drawn(scene, camera_at(100), {width, height, samples});
    scene.occlusion_radius_mm = 6.0;
    const Image shaded = drawn(scene, camera_at(100), {width, height, samples});
    for (const double x_mm : {0.0, -26.0, 27.0})
      EXPECT_NEAR(green(shaded, x_mm), green(plain, x_mm), code_tolerance);
  }
}

TEST(Occlusion, TouchingBall)
{
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    Scene scene = wall_with_ball(0.0);
    scene.drawables[1].X_world_mesh.translation() = Eigen::Vector3d(0, 0, 0);  // a hemisphere on the wall
    const Image plain = drawn(scene, camera_at(100), {width, height, samples});
    scene.occlusion_radius_mm = 6.0;
    const Image shaded = drawn(scene, camera_at(100), {width, height, samples});
    EXPECT_LT(green(shaded, 11.0), green(plain, 11.0) - 2 * code_tolerance);
    EXPECT_LT(green(shaded, 11.0), green(shaded, 14.0));
    EXPECT_NEAR(green(shaded, 24.0), green(plain, 24.0), code_tolerance);
    EXPECT_NEAR(green(shaded, 0.0), green(plain, 0.0), code_tolerance);
    // Left and right alike, up to the pattern of directions.
    EXPECT_NEAR(green(shaded, 12.0), green(shaded, -12.0), 12);
  }
}

}  // namespace vrda::view::occlusion_test
