#include <gtest/gtest.h>

#include <cmath>

#include "player/view/pictures.hpp"
#include "support/meshes.hpp"

namespace vrda::occlusion_test {

using namespace test;

constexpr int width = 320, height = 240;
constexpr double mm_per_pixel = 2.0 * 25.0 / height;  // at the distance of camera_at(100)

/// A wall of 100 mm that faces the camera, and a ball of 10 mm in front of it at the height of the picture's
/// middle, `gap_mm` away.
view::Scene wall_with_ball(double gap_mm)
{
  view::Scene scene = dark_scene();
  add(scene, facing_sheet(100.0), plain({0.5F, 0.5F, 0.5F}));
  add(scene, ball(10.0, 32, 64), plain({0.5F, 0.5F, 0.5F}), {0, 0, 10.0 + gap_mm});
  return scene;
}

int green(const view::Image& image, double x_mm)
{
  return at(image, static_cast<int>(std::lround(width / 2 + x_mm / mm_per_pixel)), height / 2)[1];
}

TEST(Occlusion, AFlatWallAndAFreeBallKeepTheirColour)
{
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    view::Scene scene = wall_with_ball(40.0);
    const view::Image plain = drawn(scene, camera_at(100), {width, height, samples});
    scene.occlusion_radius_mm = 6.0;
    const view::Image shaded = drawn(scene, camera_at(100), {width, height, samples});
    for (const double x_mm : {0.0, -26.0, 27.0})
      EXPECT_NEAR(green(shaded, x_mm), green(plain, x_mm), code_tolerance);
  }
}

TEST(Occlusion, SurfacesThatTouchDarkenWithinTheRadius)
{
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    view::Scene scene = wall_with_ball(0.0);
    scene.drawables[1].X_world_mesh.translation() = Eigen::Vector3d(0, 0, 0);  // a hemisphere on the wall
    const view::Image plain = drawn(scene, camera_at(100), {width, height, samples});
    scene.occlusion_radius_mm = 6.0;
    const view::Image shaded = drawn(scene, camera_at(100), {width, height, samples});
    EXPECT_LT(green(shaded, 11.0), green(plain, 11.0) - 2 * code_tolerance);
    EXPECT_LT(green(shaded, 11.0), green(shaded, 14.0));
    EXPECT_NEAR(green(shaded, 24.0), green(plain, 24.0), code_tolerance);
    EXPECT_NEAR(green(shaded, 0.0), green(plain, 0.0), code_tolerance);
    // Left and right alike, up to the pattern of directions.
    EXPECT_NEAR(green(shaded, 12.0), green(shaded, -12.0), 12);
  }
}

TEST(Occlusion, LinesAndTheBackgroundStayAsTheyAre)
{
  view::Scene scene = wall_with_ball(0.0);
  scene.drawables[0].is_shown = false;
  scene.mode = view::DrawMode::hidden_line;
  const view::Image lines = drawn(scene, camera_at(100));
  scene.occlusion_radius_mm = 6.0;
  EXPECT_EQ(drawn(scene, camera_at(100)).rgba, lines.rgba);
  scene.mode = view::DrawMode::smooth;
  scene.background = {{0.2F, 0.5F, 0.8F}, {0.2F, 0.5F, 0.8F}};
  const view::Image shaded = drawn(scene, camera_at(100));
  EXPECT_NEAR(at(shaded, 3, 3)[1], srgb_code(0.5), code_tolerance);
}

TEST(Occlusion, EqualScenesGiveEqualBytesAndShotsDoNotMix)
{
  view::Scene scene = wall_with_ball(0.0);
  scene.occlusion_radius_mm = 6.0;
  EXPECT_EQ(drawn(scene, camera_at(100)).rgba, drawn(scene, camera_at(100)).rgba);
  // A shot in a corner with odd sizes is the same as alone.
  const auto renderer = view::make_offscreen_renderer({161, 121, 1});
  renderer->load(scene);
  view::Camera camera = camera_at(100);
  camera.aspect = 80.0 / 60.0;
  const auto picture = [&](int x, int y) {
    const view::Shot shot{camera, {x, y, 80, 60}};
    const view::Image image = renderer->draw(scene, {&shot, 1}, nullptr);
    std::vector<Codes> codes;
    for (int row = 0; row < 60; ++row) {
      for (int column = 0; column < 80; ++column) codes.push_back(at(image, x + column, y + row));
    }
    return codes;
  };
  EXPECT_EQ(picture(0, 1), picture(80, 61));
}

}  // namespace vrda::occlusion_test
