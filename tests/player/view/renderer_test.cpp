// What the renderer draws, and image files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/text.hpp"
#include "player/view/pictures.hpp"
#include "support/allocation_count.hpp"
#include "support/meshes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "view/gl_mesh.hpp"
#include "view/image.hpp"
#include "view/renderer.hpp"

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

TEST(Renderer, ImpossibleSize)
{
  EXPECT_THAT(test::input_error([&] {
                make_offscreen_renderer({100000, 10});
              }),
              test::refuses({.field = "size", .found = "100000x10"}));
}

void expect_near(const Codes& found, const Codes& expected)
{
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k], expected[k], code_tolerance) << "channel " << k;
}

int n_pixels(const Image& image, const Codes& codes)
{
  int n = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) n += at(image, x, y) == codes ? 1 : 0;
  }
  return n;
}

/// A white square of 40 mm, 160 of 240 pixels wide for camera_at(120).
Scene square()
{
  Scene scene = dark_scene();
  scene.background = {{0.05F, 0.05F, 0.05F}, {0.05F, 0.05F, 0.05F}};
  add(scene, facing_sheet(40), plain({1, 1, 1}));
  return scene;
}

constexpr Codes white{255, 255, 255, 255};

TEST(DrawMode, HiddenLines)
{
  Scene scene = square();
  add(scene, facing_sheet(20), plain({1, 0, 0}), {0, 0, -5});  // behind
  scene.mode = DrawMode::wire;
  const Image wire = drawn(scene, camera_at(120), {width, height, 1});
  constexpr Codes red{255, 0, 0, 255};
  EXPECT_GT(n_pixels(wire, red), 100);
  scene.mode = DrawMode::hidden_line;
  const Image hidden = drawn(scene, camera_at(120), {width, height, 1});
  EXPECT_EQ(n_pixels(hidden, red), 0);
  // Edges are not hidden by their own faces.
  EXPECT_NEAR(n_pixels(hidden, white), 16 * 80, 40);
}

TEST(DrawMode, TextureScale)
{
  Scene scene = dark_scene();
  Material material = plain({0.5F, 0.5F, 0.5F});
  material.mottling = 0.2F;
  add(scene, facing_sheet(400), material);
  // Red and blue, repeated every 100 mm along mesh X (= world X). Eight columns, so that the middle of each
  // half is not blended with the other.
  scene.texture = {8, 1, {}, 100.0};
  for (int i = 0; i < 8; ++i) {
    const std::uint8_t red = i < 4 ? 255 : 0, blue = i < 4 ? 0 : 255;
    scene.texture.rgb.insert(scene.texture.rgb.end(), {red, 0, blue});
  }
  const Image image = drawn(scene, camera_at(400));
  // 120 pixels are 100 mm; the image centre is mesh X = 0, where a tile starts.
  for (const int repeat : {-1, 0, 1}) {
    expect_near(at(image, width / 2 + 120 * repeat + 30, 50), {255, 0, 0, 255});
    if (repeat < 1) {
      expect_near(at(image, width / 2 + 120 * repeat + 90, 50), {0, 0, 255, 255});
    }
  }
}

TEST(Colours, OfVertices)
{
  Scene scene = square();
  scene.background = {};
  Drawable& sheet = scene.drawables[0];
  sheet.colours.assign(sheet.mesh.vertices.size(), {200, 100, 50, 255});
  expect_near(at(drawn(scene, camera_at(120)), width / 2 + 9, height / 2 + 5), {200, 100, 50, 255});
  sheet.colours.assign(sheet.mesh.vertices.size(), {200, 100, 50, 51});
  const auto part = [](int code) { return srgb_code(0.2 * linear_value(code)); };
  expect_near(at(drawn(scene, camera_at(120)), width / 2 + 9, height / 2 + 5),
              {part(200), part(100), part(50), 255});
}

TEST(Revision, Uploads)
{
  Scene scene = square();
  scene.background = {};
  const Camera camera = camera_at(120);
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height});
  renderer->load(scene);
  const auto middle = [&] { return at(renderer->draw(scene, camera), width / 2 + 9, height / 2 + 5); };
  EXPECT_EQ(middle(), white);
  Drawable& sheet = scene.drawables[0];
  for (RenderVertex& vertex : sheet.mesh.vertices) vertex.position_mm[0] += 100.0F;
  EXPECT_EQ(middle(), white);
  ++sheet.revision;
  EXPECT_EQ(middle(), (Codes{0, 0, 0, 255}));
  for (RenderVertex& vertex : sheet.mesh.vertices) vertex.position_mm[0] -= 100.0F;
  sheet.colours.assign(sheet.mesh.vertices.size(), {0, 255, 0, 255});
  ++sheet.revision;
  EXPECT_EQ(middle(), (Codes{0, 255, 0, 255}));
  const RenderMesh whole = sheet.mesh;
  sheet.mesh.triangles.clear();
  ++sheet.revision;
  EXPECT_EQ(middle(), (Codes{0, 0, 0, 255}));
  sheet.mesh = whole;
  ++sheet.revision;
  EXPECT_EQ(middle(), (Codes{0, 255, 0, 255}));
  // It may be larger than at its load.
  sheet.mesh.triangles.clear();
  for (int k = 0; k < 2; ++k)
    sheet.mesh.triangles.insert(sheet.mesh.triangles.end(), whole.triangles.begin(), whole.triangles.end());
  ++sheet.revision;
  EXPECT_EQ(middle(), (Codes{0, 255, 0, 255}));
}

// What is on the camera's side of a section is not drawn, whatever the sign of its normal.
TEST(Section, CameraSide)
{
  for (const double sign : {1.0, -1.0}) {
    SCOPED_TRACE(sign);
    Scene scene = square();
    scene.background = {};
    scene.section = SectionPlane{sign * Eigen::Vector3d::UnitZ(), -sign};  // 1 mm behind the square
    EXPECT_EQ(at(drawn(scene, camera_at(120)), width / 2 + 9, height / 2 + 5), (Codes{0, 0, 0, 255}));
    scene.section->at_mm = sign;
    EXPECT_EQ(at(drawn(scene, camera_at(120)), width / 2 + 9, height / 2 + 5), white);
  }
}

TEST(Resize, DrawsAsIfMadeSo)
{
  const Scene scene = joint_scene();
  const Camera camera = joint_camera(scene);
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48});
  renderer->load(scene);
  renderer->draw(scene, camera);
  renderer->resize(width, height);
  EXPECT_EQ(renderer->width(), width);
  EXPECT_EQ(renderer->height(), height);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, drawn(scene, camera).rgba);
  EXPECT_THROW(renderer->resize(0, 10), InputError);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, drawn(scene, camera).rgba);
}

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

// What a frame leaves outside the bounds of the next one's surfaces, in colours or depths, would be seen.
TEST(Occlusion, AfterAnotherFrame)
{
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    const RenderOptions options{width, height, samples};
    Scene scene = wall_with_ball(0.0);
    scene.background = background_of(Backdrop::studio);
    scene.occlusion_radius_mm = 6.0;
    const std::unique_ptr<Renderer> renderer = make_offscreen_renderer(options);
    renderer->load(scene);
    renderer->draw(scene, camera_at(100));
    scene.drawables[0].is_shown = false;
    scene.drawables[1].material.opacity = 0.5F;
    add(scene, ball(8.0, 32, 64), plain({0.5F, 0.5F, 0.5F}), {3.0, 0, 2.0});
    renderer->load(scene);
    EXPECT_EQ(renderer->draw(scene, camera_at(100)).rgba, drawn(scene, camera_at(100), options).rgba);
  }
}

// A shot ends in the middle of a pair of pixels: beyond it nothing was computed.
TEST(Occlusion, AtTheEdgesOfAShot)
{
  Scene scene = dark_scene();
  add(scene, facing_sheet(100.0), plain({0.5F, 0.5F, 0.5F}));
  scene.occlusion_radius_mm = 6.0;
  for (const int samples : {1, 4}) {
    SCOPED_TRACE(samples);
    const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height, samples});
    renderer->load(scene);
    const Viewport view{20, 10, 42, 31};
    const Shot shot{camera_at(100), view};
    const Image& image = renderer->draw(scene, {&shot, 1}, nullptr);
    const int x = view.x + view.width / 2, y = view.y + view.height / 2;
    EXPECT_GT(at(image, x, y)[1], 0);
    for (const auto& [edge_x, edge_y] :
         {std::pair{view.x, y}, {view.x + view.width - 1, y}, {x, view.y}, {x, view.y + view.height - 1}})
      EXPECT_NEAR(at(image, edge_x, edge_y)[1], at(image, x, y)[1], code_tolerance);
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

// Glyphs cover by their font and blend in linear light.
TEST(Overlay, Glyphs)
{
  Scene scene = dark_scene();
  scene.background = {{0.2F, 0.2F, 0.2F}, {0.2F, 0.2F, 0.2F}};
  constexpr VertexColour half_white{255, 255, 255, 128};
  Overlay overlay;
  overlay.vertices = {{0, 0, 0, 0, half_white},
                      {64, 0, 1, 0, half_white},
                      {64, 48, 1, 1, half_white},
                      {0, 48, 0, 1, half_white}};
  overlay.indices = {0, 1, 2, 0, 2, 3};
  overlay.commands.push_back({{0, 0, 64, 48}, 0, 6, 0});
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48});
  renderer->load(scene);
  renderer->load(OverlayFont{4, 2, {255, 255, 0, 0, 255, 255, 0, 0}});  // covers its left half
  const Shot shot{camera_at(100), {0, 0, 64, 48}};
  const Image& image = renderer->draw(scene, {&shot, 1}, &overlay);
  EXPECT_NEAR(at(image, 8, 20)[1], srgb_code(0.2 + (1.0 - 0.2) * 128.0 / 255.0), code_tolerance);
  EXPECT_NEAR(at(image, 56, 20)[1], srgb_code(0.2), code_tolerance);
}

// The pixels of an unchanged panel are those of a new one, and a changed one is drawn.
TEST(Overlay, KeptPanel)
{
  const Scene scene = dark_scene();
  const auto overlay_of = [](VertexColour panel) {
    Overlay overlay;
    const auto add = [&](float left, float right, VertexColour colour) {
      const auto first = static_cast<std::uint32_t>(overlay.vertices.size());
      for (const auto& [x, y] : {std::pair{left, 0.0F}, {right, 0.0F}, {right, 48.0F}, {left, 48.0F}})
        overlay.vertices.push_back({x, y, 0, 0, colour});
      overlay.commands.push_back(
          {{0, 0, 64, 48}, static_cast<std::uint32_t>(overlay.indices.size()), 6, first});
      for (const std::uint32_t k : {0U, 1U, 2U, 0U, 2U, 3U}) overlay.indices.push_back(k);
    };
    add(0, 32, panel);
    overlay.panels.push_back({{0, 0, 32, 48}, 0, 1, 0, 4});
    add(24, 40, {0, 255, 0, 128});  // over a part of the panel
    return overlay;
  };
  const OverlayFont font{2, 2, {255, 255, 255, 255}};
  const Shot shot{camera_at(100), {0, 0, 64, 48}};
  const std::unique_ptr<Renderer> kept = make_offscreen_renderer({64, 48});
  kept->load(scene);
  kept->load(font);
  for (const std::uint8_t red : std::array<std::uint8_t, 5>{100, 100, 200, 200, 100}) {
    const Overlay overlay = overlay_of({red, 10, 10, 255});
    const std::unique_ptr<Renderer> fresh = make_offscreen_renderer({64, 48});
    fresh->load(scene);
    fresh->load(font);
    EXPECT_EQ(kept->draw(scene, {&shot, 1}, &overlay).rgba, fresh->draw(scene, {&shot, 1}, &overlay).rgba);
    EXPECT_NEAR(at(kept->draw(scene, {&shot, 1}, &overlay), 8, 20)[0], red, code_tolerance);
  }
  // Its triangles are not drawn again: without them the panel is still there.
  Overlay overlay = overlay_of({100, 10, 10, 255});
  overlay.commands[0].n_indices = 0;
  EXPECT_NEAR(at(kept->draw(scene, {&shot, 1}, &overlay), 8, 20)[0], 100, code_tolerance);
}

// Two joints side by side, and one over the other.
TEST(Shots, OfTwoJoints)
{
  Scene scene = dark_scene(), other = dark_scene();
  add(scene, test::facing_sheet(600), test::plain({1, 0, 0}));
  add(other, test::facing_sheet(600), test::plain({0, 0, 1}, 0.5F), {0, 0, 10});
  scene.other = &other;
  Camera half = camera_at(100);
  half.aspect = 32.0 / 48.0;
  const Shot left{half, {0, 0, 32, 48}, true, false}, right{half, {32, 0, 32, 48}, false, true};
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48});
  renderer->load(scene);
  const Image beside = renderer->draw(scene, std::array{left, right}, nullptr);
  EXPECT_EQ(at(beside, 16, 24), (test::Codes{255, 0, 0, 255}));
  EXPECT_EQ(at(beside, 48, 24)[0], 0);
  EXPECT_NEAR(at(beside, 48, 24)[2], srgb_code(0.5), code_tolerance);
  const Image over = renderer->draw(scene, camera_at(100));
  EXPECT_NEAR(at(over, 32, 24)[0], srgb_code(0.5), code_tolerance);
  EXPECT_NEAR(at(over, 32, 24)[2], srgb_code(0.5), code_tolerance);
}

class RendererAllocation : public testing::TestWithParam<int> {
};  // samples: they select the transparency algorithm

TEST_P(RendererAllocation, HundredFrames)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  Scene scene = joint_scene();
  Overlay overlay;
  overlay.vertices.resize(3);
  overlay.indices = {0, 1, 2};
  overlay.commands.push_back({{0, 0, 64, 48}, 0, 3, 0});
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48, GetParam()});
  renderer->load(scene);
  renderer->load(OverlayFont{1, 1, {255}});
  const Shot shot{joint_camera(scene), {0, 0, 64, 48}};
  const auto draw_all_modes = [&] {
    for (const DrawMode mode :
         {DrawMode::wire, DrawMode::hidden_line, DrawMode::flat, DrawMode::smooth, DrawMode::textured}) {
      scene.mode = mode;
      ++scene.drawables[0].revision;
      renderer->draw(scene, {&shot, 1}, &overlay);
    }
  };
  draw_all_modes();  // shaders of each mode are compiled on first use
  const long n_before = test::allocations_of_thread();
  for (int i = 0; i < 20; ++i) draw_all_modes();
  EXPECT_EQ(test::allocations_of_thread(), n_before);
  // The counter works.
  const std::vector<int> counted(10);
  EXPECT_EQ(test::allocations_of_thread(), n_before + 1);
}

INSTANTIATE_TEST_SUITE_P(OneAndMoreSamples, RendererAllocation, testing::Values(1, 4));

RenderMesh mesh_of(const Mesh& mesh)
{
  Scene scene;
  add(scene, mesh, plain({1, 1, 1}));
  return scene.drawables[0].mesh;
}

Eigen::Vector3d corner_mm(const RenderMesh& mesh, std::uint32_t vertex)
{
  return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[vertex].position_mm.data()).cast<double>();
}

/// Largest depth of triangle centroids inside a ball of `radius_mm`.
double sagitta_mm(const RenderMesh& mesh, const std::vector<std::uint32_t>& triangles, double radius_mm)
{
  double most_mm = 0.0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const Eigen::Vector3d middle_mm = (corner_mm(mesh, triangles[i]) + corner_mm(mesh, triangles[i + 1]) +
                                       corner_mm(mesh, triangles[i + 2])) /
                                      3.0;
    most_mm = std::max(most_mm, radius_mm - middle_mm.norm());
  }
  return most_mm;
}

TEST(Detail, LevelsOfABall)
{
  constexpr double radius_mm = 20.0;
  const RenderMesh mesh = mesh_of(ball(radius_mm, 96, 192));
  const std::vector<DetailLevel> levels = levels_of(mesh);
  ASSERT_GE(levels.size(), 4U);
  EXPECT_EQ(levels[0].triangles.size(), mesh.triangles.size());
  EXPECT_EQ(levels[0].error_mm, 0.0);
  const double whole_mm = sagitta_mm(mesh, mesh.triangles, radius_mm);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_LT(levels[i].triangles.size(), 0.8 * static_cast<double>(levels[i - 1].triangles.size()));
    EXPECT_GT(levels[i].error_mm, levels[i - 1].error_mm);
    // meshoptimizer's error is a mean over the planes around a vertex: the largest distance is up to about
    // twice that.
    EXPECT_LE(sagitta_mm(mesh, levels[i].triangles, radius_mm), whole_mm + 2.0 * levels[i].error_mm);
    for (const std::uint32_t vertex : levels[i].triangles) ASSERT_LT(vertex, mesh.vertices.size());
  }
  EXPECT_LT(levels.back().triangles.size(), mesh.triangles.size() / 10);
}

TEST(PngFile, RoundTrip)
{
  // Odd sizes reveal a wrong stride; every byte differs from its neighbours; every fifth pixel is
  // transparent.
  Image image{37, 11, {}};
  for (int i = 0; i < image.width * image.height; ++i) {
    for (const int byte : {7 * i, 13 * i + 1, 29 * i + 2})
      image.rgba.push_back(static_cast<std::uint8_t>(byte));
    image.rgba.push_back(i % 5 == 0 ? 0 : 255);
  }
  const Scratch scratch;
  const std::string path = (scratch.path() / "pattern.png").string();
  write_png(image, path);
  const Texture read = read_png_texture(path);
  EXPECT_EQ(read.width, image.width);
  EXPECT_EQ(read.height, image.height);
  ASSERT_EQ(read.rgb.size(), image.rgba.size() / 4 * 3);
  for (std::size_t k = 0; k < read.rgb.size(); ++k) {
    const std::size_t pixel = k / 3;
    EXPECT_EQ(read.rgb[k], pixel % 5 == 0 ? 255 : image.rgba[4 * pixel + k % 3]) << "over white";
  }
  const std::string bytes = read_bytes(path);
  EXPECT_NE(bytes.find("sRGB"), std::string::npos);
  EXPECT_EQ(bytes.find("tIME"), std::string::npos);
  write_png(image, path);
  EXPECT_TRUE(read_bytes(path) == bytes);
}

}  // namespace vrda::view::renderer_test
