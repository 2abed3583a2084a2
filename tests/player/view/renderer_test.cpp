#include "view/renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "player/view/pictures.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"

namespace vrda::renderer_test {

using namespace test;

constexpr int width = 320, height = 240;

TEST(Renderer, AnEmptySceneIsItsBackground)
{
  view::Scene scene = dark_scene();
  scene.background = {{0.2F, 0.5F, 0.8F}, {0.2F, 0.5F, 0.8F}};
  const view::Image image = drawn(scene, camera_at(100));
  ASSERT_EQ(image.rgba.size(), 4U * width * height);
  const Codes first = at(image, 0, 0);
  const std::array<double, 3> linear{0.2, 0.5, 0.8};
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(first[k], srgb_code(linear[k]), code_tolerance);
  EXPECT_EQ(first[3], 255);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) ASSERT_EQ(at(image, x, y), first);
  }
}

TEST(Renderer, TheTopOfTheBackgroundIsTheFirstRow)
{
  view::Scene scene = dark_scene();
  scene.background = {{1, 1, 1}, {0, 0, 0}};
  const view::Image image = drawn(scene, camera_at(100));
  for (const int y : {0, 60, 120, 239}) {
    const double linear = 1.0 - (y + 0.5) / height;
    EXPECT_NEAR(at(image, 7, y)[1], srgb_code(linear), code_tolerance) << y;
  }
}

TEST(Renderer, ABallsSilhouetteHasTheAreaOfItsPerspectiveProjection)
{
  constexpr double radius_mm = 20.0, distance_mm = 150.0;
  view::Scene scene = dark_scene();
  add(scene, ball(radius_mm, 128, 256), plain({1, 1, 1}));
  const view::RenderOptions options{640, 480};
  const view::Image image = drawn(scene, camera_at(distance_mm), options);
  double area_px = 0.0;  // sum of pixel coverage: white over black, resolved in linear light
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) area_px += linear_value(at(image, x, y)[0]);
  }
  // The tangent cone of the ball has a half angle of asin(r / d). Half the image height has tangent 0.25.
  const double radius_px =
      0.5 * options.height / 0.25 * radius_mm / std::sqrt(distance_mm * distance_mm - radius_mm * radius_mm);
  const double expected_px = pi * radius_px * radius_px;
  // Facets: 1 - sin(a) / a for a = 2 pi / 256 and for the rings, twice 1e-4. Samples: 800 border pixels with
  // random errors of 0.15 are 5 of 52,000 pixels. Codes of partly covered pixels: rounded by 1/510 of them.
  EXPECT_NEAR(area_px / expected_px, 1.0, 4e-4);
}

TEST(Renderer, ALitBallFollowsLambert)
{
  view::Scene scene = dark_scene();
  scene.lighting.sky = scene.lighting.ground = Eigen::Vector3f::Zero();
  scene.lighting.lights.push_back({Eigen::Vector3f(0, 0, 1), {0.8F, 0.8F, 0.8F}});
  add(scene, ball(20, 128, 256), plain({0.5F, 0.25F, 1.0F}));
  // From far away the projection is nearly parallel: pixel offset / radius is the sine of the slope.
  view::Camera camera = camera_at(10000);
  camera.half_height_tangent = 0.0025;  // 25 mm half the height
  camera.near_mm = 9000;
  camera.far_mm = 11000;
  const view::Image image = drawn(scene, camera);
  for (const int offset_px : {0, 48, 72}) {
    const double offset_mm = (offset_px + 0.5) * 25.0 / 120.0;
    const double facing = std::sqrt(1.0 - offset_mm * offset_mm / 400.0);
    const Codes found = at(image, width / 2 + offset_px, height / 2);
    EXPECT_NEAR(found[0], srgb_code(0.4 * facing), code_tolerance);
    EXPECT_NEAR(found[1], srgb_code(0.2 * facing), code_tolerance);
    EXPECT_NEAR(found[2], srgb_code(0.8 * facing), code_tolerance);
  }
}

TEST(Renderer, OpaqueSurfacesHideWhatIsBehindWhateverTheOrder)
{
  for (const double first_z_mm : {-10.0, 10.0}) {
    view::Scene scene = dark_scene();
    add(scene, facing_sheet(200), plain({1, 0, 0}), {0, 0, first_z_mm});
    add(scene, facing_sheet(200), plain({0, 1, 0}), {0, 0, 0});
    const Codes expected = first_z_mm > 0 ? Codes{255, 0, 0, 255} : Codes{0, 255, 0, 255};
    EXPECT_EQ(at(drawn(scene, camera_at(100)), width / 2, height / 2), expected);
  }
}

TEST(Renderer, TranslucentOverOpaqueBlendsInLinearLight)
{
  // Loaded first, drawn last.
  view::Scene scene = dark_scene();
  add(scene, facing_sheet(200), plain({1.0F, 0.1F, 0.0F}, 0.6F), {0, 0, 10});
  add(scene, facing_sheet(200), plain({0.0F, 0.2F, 0.9F}));
  const Codes found = at(drawn(scene, camera_at(100)), 10, 20);
  EXPECT_NEAR(found[0], srgb_code(0.6), code_tolerance);
  EXPECT_NEAR(found[1], srgb_code(0.6 * 0.1 + 0.4 * 0.2), code_tolerance);
  EXPECT_NEAR(found[2], srgb_code(0.4 * 0.9), code_tolerance);
  EXPECT_EQ(found[3], 255);
}

TEST(Renderer, TranslucentBodiesShowTheirBackFacesAndBlendFromTheFarthest)
{
  view::Scene scene = dark_scene();
  add(scene, box({0, 0, 0}, {200, 200, 10}), plain({1, 0, 0}, 0.5F), {0, 0, 30});   // near
  add(scene, box({0, 0, 0}, {200, 200, 10}), plain({0, 1, 0}, 0.5F), {0, 0, -30});  // far
  const Codes found = at(drawn(scene, camera_at(200)), width / 2, height / 2);
  // Two faces of opacity a cover 1 - (1 - a)^2 of what is behind them.
  const double covered = 0.75;
  EXPECT_NEAR(found[0], srgb_code(covered), code_tolerance);
  EXPECT_NEAR(found[1], srgb_code((1.0 - covered) * covered), code_tolerance);
}

TEST(Renderer, OpenSheetsAreLitFromBothSides)
{
  view::Scene scene = dark_scene();
  scene.lighting.sky = scene.lighting.ground = Eigen::Vector3f::Zero();
  scene.lighting.lights.push_back({Eigen::Vector3f(0, 0, 1), {1, 1, 1}});
  add(scene, facing_sheet(200), plain({1, 1, 1}));
  view::Scene turned = scene;
  turned.drawables[0].X_world_mesh.linear() = rotation_y(pi);
  EXPECT_EQ(at(drawn(scene, camera_at(100)), 50, 50), at(drawn(turned, camera_at(100)), 50, 50));
}

TEST(Renderer, MottlingVariesTheColourAboutItsMean)
{
  view::Scene scene = dark_scene();
  Material material = plain({0.5F, 0.5F, 0.5F});
  material.mottling = 0.1F;
  add(scene, facing_sheet(400), material);
  const view::Image image = drawn(scene, camera_at(400));
  double sum = 0.0;
  int lowest = 255, highest = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int code = at(image, x, y)[0];
      sum += linear_value(code);
      lowest = std::min(lowest, code);
      highest = std::max(highest, code);
    }
  }
  EXPECT_NEAR(sum / (width * height), 0.5, 0.01);  // the noise has mean zero over hundreds of patches
  EXPECT_GT(highest - lowest, 5);
  EXPECT_LT(highest - lowest, 40);
}

TEST(Renderer, EqualScenesGiveEqualBytes)
{
  const view::Scene scene = joint_scene();
  const view::Camera camera = joint_camera(scene);
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height});
  renderer->load(scene);
  const view::Image first = renderer->draw(scene, camera);
  view::Scene other = scene;
  for (view::Drawable& drawable : other.drawables) drawable.X_world_mesh.translation().x() += 5.0;
  EXPECT_NE(renderer->draw(other, camera).rgba, first.rgba);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, first.rgba);
  EXPECT_EQ(drawn(scene, camera).rgba, first.rgba);
}

TEST(Renderer, OtherSamplesGiveTheBytesOfARendererWithThem)
{
  const view::Scene scene = joint_scene();
  const view::Camera camera = joint_camera(scene);
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height, 1});
  renderer->load(scene);
  for (const int samples : {4, 1, 4}) {
    renderer->set_samples(samples);
    EXPECT_EQ(renderer->draw(scene, camera).rgba, drawn(scene, camera, {width, height, samples}).rgba);
  }
}

TEST(Renderer, TwoRenderersDoNotDisturbEachOther)
{
  const view::Scene joint = joint_scene(), empty = dark_scene();
  const std::unique_ptr<view::Renderer> large = view::make_offscreen_renderer({width, height});
  large->load(joint);
  const view::Image before = large->draw(joint, joint_camera(joint));
  {
    const std::unique_ptr<view::Renderer> small = view::make_offscreen_renderer({64, 48, 1});
    small->load(empty);
    EXPECT_EQ(at(small->draw(empty, camera_at(10)), 3, 3), (Codes{0, 0, 0, 255}));
  }
  EXPECT_EQ(large->draw(joint, joint_camera(joint)).rgba, before.rgba);
}

TEST(Renderer, ASceneIsLoadedBeforeItIsDrawn)
{
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({64, 48});
  EXPECT_THROW(renderer->draw(joint_scene(), camera_at(100)), InternalError);
}

TEST(Renderer, AnImpossibleSizeIsNamed)
{
  EXPECT_THAT(test::input_error([&] {
                view::make_offscreen_renderer({100000, 10});
              }),
              test::refuses({.field = "size", .found = "100000x10"}));
}

}  // namespace vrda::renderer_test
