#include <gtest/gtest.h>

#include "core/text.hpp"
#include "player/view/pictures.hpp"
#include "support/meshes.hpp"

namespace vrda::view::modes_test {

using test::at;
using test::code_tolerance;
using test::Codes;
using test::srgb_code;

constexpr int width = 320, height = 240;

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
  Scene scene = test::dark_scene();
  scene.background = {{0.05F, 0.05F, 0.05F}, {0.05F, 0.05F, 0.05F}};
  test::add(scene, test::facing_sheet(40), test::plain({1, 1, 1}));
  return scene;
}

constexpr Codes white{255, 255, 255, 255};

TEST(DrawMode, HiddenLines)
{
  Scene scene = square();
  test::add(scene, test::facing_sheet(20), test::plain({1, 0, 0}), {0, 0, -5});  // behind
  scene.mode = DrawMode::wire;
  const Image wire = test::drawn(scene, test::camera_at(120), {width, height, 1});
  constexpr Codes red{255, 0, 0, 255};
  EXPECT_GT(n_pixels(wire, red), 100);
  scene.mode = DrawMode::hidden_line;
  const Image hidden = test::drawn(scene, test::camera_at(120), {width, height, 1});
  EXPECT_EQ(n_pixels(hidden, red), 0);
  // Edges are not hidden by their own faces.
  EXPECT_NEAR(n_pixels(hidden, white), 16 * 80, 40);
}

TEST(DrawMode, TextureScale)
{
  Scene scene = test::dark_scene();
  Material material = test::plain({0.5F, 0.5F, 0.5F});
  material.mottling = 0.2F;
  test::add(scene, test::facing_sheet(400), material);
  // Red and blue, repeated every 100 mm along mesh X (= world X). Eight columns, so that the middle of each
  // half is not blended with the other.
  scene.texture = {8, 1, {}, 100.0};
  for (int i = 0; i < 8; ++i) {
    const std::uint8_t red = i < 4 ? 255 : 0, blue = i < 4 ? 0 : 255;
    scene.texture.rgb.insert(scene.texture.rgb.end(), {red, 0, blue});
  }
  const Image image = test::drawn(scene, test::camera_at(400));
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
  expect_near(at(test::drawn(scene, test::camera_at(120)), width / 2 + 9, height / 2 + 5),
              {200, 100, 50, 255});
  sheet.colours.assign(sheet.mesh.vertices.size(), {200, 100, 50, 51});
  const auto part = [](int code) { return srgb_code(0.2 * test::linear_value(code)); };
  expect_near(at(test::drawn(scene, test::camera_at(120)), width / 2 + 9, height / 2 + 5),
              {part(200), part(100), part(50), 255});
}

TEST(Revision, Uploads)
{
  Scene scene = square();
  scene.background = {};
  const Camera camera = test::camera_at(120);
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
  sheet.mesh.triangles.insert(sheet.mesh.triangles.end(), {0, 1, 2});
  ++sheet.revision;
  EXPECT_THROW(middle(), InternalError);
}

TEST(Shots, TwoShots)
{
  Scene scene = square();
  scene.background = {{0, 0, 1}, {0, 0, 1}};
  // The second overlaps the first and covers it because it is drawn later.
  const std::array<Shot, 2> shots{Shot{test::camera_at(60), {0, 0, 160, 240}},
                                  Shot{test::camera_at(240), {100, 60, 160, 120}}};
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height});
  renderer->load(scene);
  const Image& image = renderer->draw(scene, shots, nullptr);
  constexpr Codes blue{0, 0, 255, 255}, nothing{0, 0, 0, 255};
  EXPECT_EQ(at(image, 50, 120), white);
  EXPECT_EQ(at(image, 50, 5), white);     // 160 pixels are 60 mm: taller than the shot
  EXPECT_EQ(at(image, 102, 62), blue);    // a corner of the second, over the first
  EXPECT_EQ(at(image, 180, 120), white);  // its middle
  EXPECT_EQ(at(image, 258, 178), blue);
  EXPECT_EQ(at(image, 261, 120), nothing);
  EXPECT_EQ(at(image, 180, 181), nothing);
}

TEST(Resize, DrawsAsIfMadeSo)
{
  const Scene scene = test::joint_scene();
  const Camera camera = test::joint_camera(scene);
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({64, 48});
  renderer->load(scene);
  renderer->draw(scene, camera);
  renderer->resize(width, height);
  EXPECT_EQ(renderer->width(), width);
  EXPECT_EQ(renderer->height(), height);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, test::drawn(scene, camera).rgba);
  EXPECT_THROW(renderer->resize(0, 10), InputError);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, test::drawn(scene, camera).rgba);
}

}  // namespace vrda::view::modes_test
