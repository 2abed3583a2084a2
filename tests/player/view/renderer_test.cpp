#include "view/renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "player/view/pictures.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"

namespace vrda::view::renderer_test {

using namespace test;

constexpr int width = 320, height = 240;

TEST(Renderer, Background)
{
  Scene scene = dark_scene();
  scene.background = {{1, 1, 1}, {0, 0, 0}};
  const Image image = drawn(scene, camera_at(100));
  for (const int y : {0, 60, 120, 239}) {
    const double linear = 1.0 - (y + 0.5) / height;
    EXPECT_NEAR(at(image, 7, y)[1], srgb_code(linear), code_tolerance) << y;
  }
}

// A balls silhouette has the area of its perspective projection.
TEST(Renderer, SilhouetteOfABall)
{
  constexpr double radius_mm = 20.0, distance_mm = 150.0;
  Scene scene = dark_scene();
  add(scene, ball(radius_mm, 128, 256), plain({1, 1, 1}));
  const RenderOptions options{640, 480};
  const Image image = drawn(scene, camera_at(distance_mm), options);
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
  Scene scene = dark_scene();
  scene.lighting.sky = scene.lighting.ground = Eigen::Vector3f::Zero();
  scene.lighting.lights.push_back({Eigen::Vector3f(0, 0, 1), {0.8F, 0.8F, 0.8F}});
  add(scene, ball(20, 128, 256), plain({0.5F, 0.25F, 1.0F}));
  // From far away the projection is nearly parallel: pixel offset / radius is the sine of the slope.
  Camera camera = camera_at(10000);
  camera.half_height_tangent = 0.0025;  // 25 mm half the height
  camera.near_mm = 9000;
  camera.far_mm = 11000;
  const Image image = drawn(scene, camera);
  for (const int offset_px : {0, 48, 72}) {
    const double offset_mm = (offset_px + 0.5) * 25.0 / 120.0;
    const double facing = std::sqrt(1.0 - offset_mm * offset_mm / 400.0);
    const Codes found = at(image, width / 2 + offset_px, height / 2);
    EXPECT_NEAR(found[0], srgb_code(0.4 * facing), code_tolerance);
    EXPECT_NEAR(found[1], srgb_code(0.2 * facing), code_tolerance);
    EXPECT_NEAR(found[2], srgb_code(0.8 * facing), code_tolerance);
  }
}

// Opaque surfaces hide what is behind whatever the order.
TEST(Renderer, OpaqueHides)
{
  for (const double first_z_mm : {-10.0, 10.0}) {
    Scene scene = dark_scene();
    add(scene, facing_sheet(200), plain({1, 0, 0}), {0, 0, first_z_mm});
    add(scene, facing_sheet(200), plain({0, 1, 0}), {0, 0, 0});
    const Codes expected = first_z_mm > 0 ? Codes{255, 0, 0, 255} : Codes{0, 255, 0, 255};
    EXPECT_EQ(at(drawn(scene, camera_at(100)), width / 2, height / 2), expected);
  }
}

// Translucent bodies show their back faces and blend from the farthest.
TEST(Renderer, BackFaces)
{
  Scene scene = dark_scene();
  add(scene, box({0, 0, 0}, {200, 200, 10}), plain({1, 0, 0}, 0.5F), {0, 0, 30});   // near
  add(scene, box({0, 0, 0}, {200, 200, 10}), plain({0, 1, 0}, 0.5F), {0, 0, -30});  // far
  const Codes found = at(drawn(scene, camera_at(200)), width / 2, height / 2);
  // Two faces of opacity a cover 1 - (1 - a)^2 of what is behind them.
  const double covered = 0.75;
  EXPECT_NEAR(found[0], srgb_code(covered), code_tolerance);
  EXPECT_NEAR(found[1], srgb_code((1.0 - covered) * covered), code_tolerance);
}

TEST(Renderer, OpenSheet)
{
  Scene scene = dark_scene();
  scene.lighting.sky = scene.lighting.ground = Eigen::Vector3f::Zero();
  scene.lighting.lights.push_back({Eigen::Vector3f(0, 0, 1), {1, 1, 1}});
  add(scene, facing_sheet(200), plain({1, 1, 1}));
  Scene turned = scene;
  turned.drawables[0].X_world_mesh.linear() = rotation_y(pi);
  EXPECT_EQ(at(drawn(scene, camera_at(100)), 50, 50), at(drawn(turned, camera_at(100)), 50, 50));
}

TEST(Renderer, EqualScenesGiveEqualBytes)
{
  const Scene scene = joint_scene();
  const Camera camera = joint_camera(scene);
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height});
  renderer->load(scene);
  const Image first = renderer->draw(scene, camera);
  Scene other = scene;
  for (Drawable& drawable : other.drawables) drawable.X_world_mesh.translation().x() += 5.0;
  EXPECT_NE(renderer->draw(other, camera).rgba, first.rgba);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, first.rgba);
  EXPECT_EQ(drawn(scene, camera).rgba, first.rgba);
}

// Other samples give the bytes of a renderer with them.
TEST(Renderer, ChangeOfSamples)
{
  const Scene scene = joint_scene();
  const Camera camera = joint_camera(scene);
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height, 1});
  renderer->load(scene);
  for (const int samples : {4, 1, 4}) {
    renderer->set_samples(samples);
    EXPECT_EQ(renderer->draw(scene, camera).rgba, drawn(scene, camera, {width, height, samples}).rgba);
  }
}

TEST(Renderer, DrawBeforeLoad)
{
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48});
  EXPECT_THROW(renderer->draw(joint_scene(), camera_at(100)), InternalError);
}

TEST(Renderer, ImpossibleSize)
{
  EXPECT_THAT(test::input_error([&] {
                make_offscreen_renderer({100000, 10});
              }),
              test::refuses({.field = "size", .found = "100000x10"}));
}

}  // namespace vrda::view::renderer_test
