#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "core/text.hpp"
#include "player/view/pictures.hpp"
#include "support/meshes.hpp"

namespace vrda::modes_test {

using test::at;
using test::code_tolerance;
using test::Codes;
using test::srgb_code;

constexpr int width = 320, height = 240;

void expect_near(const Codes& found, const Codes& expected)
{
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(found[k], expected[k], code_tolerance) << "channel " << k;
}

int n_pixels(const view::Image& image, const Codes& codes)
{
  int n = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) n += at(image, x, y) == codes ? 1 : 0;
  }
  return n;
}

/// A white square of 40 mm, 160 of 240 pixels wide for camera_at(120).
view::Scene square()
{
  view::Scene scene = test::dark_scene();
  scene.background = {{0.05F, 0.05F, 0.05F}, {0.05F, 0.05F, 0.05F}};
  test::add(scene, test::facing_sheet(40), test::plain({1, 1, 1}));
  return scene;
}

constexpr Codes white{255, 255, 255, 255};

TEST(DrawMode, WiresAreTheEdgesOfTheTriangles)
{
  view::Scene scene = square();
  scene.mode = view::DrawMode::wire;
  const view::Image image = test::drawn(scene, test::camera_at(120), {width, height, 1});
  const int n = n_pixels(image, white);
  // 2 x 2 cells: twelve sides and four diagonals of 80 rows or columns each, one pixel per row or column.
  EXPECT_NEAR(n, 16 * 80, 40);
}

TEST(DrawMode, HiddenLinesAreHiddenAndOthersAreNot)
{
  view::Scene scene = square();
  test::add(scene, test::facing_sheet(20), test::plain({1, 0, 0}), {0, 0, -5});  // behind
  scene.mode = view::DrawMode::wire;
  const view::Image wire = test::drawn(scene, test::camera_at(120), {width, height, 1});
  constexpr Codes red{255, 0, 0, 255};
  EXPECT_GT(n_pixels(wire, red), 100);
  scene.mode = view::DrawMode::hidden_line;
  const view::Image hidden = test::drawn(scene, test::camera_at(120), {width, height, 1});
  EXPECT_EQ(n_pixels(hidden, red), 0);
  // Edges are not hidden by their own faces.
  EXPECT_NEAR(n_pixels(hidden, white), 16 * 80, 40);
}

TEST(VertexLighting, OfAFineBallIsThatOfPixelsAndOpenSheetsStay)
{
  view::Scene scene = test::dark_scene();
  scene.lighting = view::studio_lighting();
  Material material = test::plain({0.8F, 0.7F, 0.6F});
  material.specular = 0.2F;
  const auto drawn = [&](bool has_vertex_lighting) {
    scene.has_vertex_lighting = has_vertex_lighting;
    return test::drawn(scene, test::camera_at(150), {width, height, 1});
  };
  // Mean over the picture, a third of which is the ball; its silhouette is the same.
  const auto mean_difference = [&] {
    const view::Image a = drawn(true), b = drawn(false);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) sum += std::abs(int{a.rgba[i]} - int{b.rgba[i]});
    return sum / static_cast<double>(a.rgba.size());
  };
  test::add(scene, test::facing_sheet(40), material);
  EXPECT_EQ(mean_difference(), 0.0) << "an open sheet is lit on both sides";
  scene.drawables.clear();
  test::add(scene, test::ball(20, 80, 160), material);
  EXPECT_LT(mean_difference(), 0.1) << "cells of 2.2 degrees";
  scene.drawables.clear();
  test::add(scene, test::ball(20, 6, 8), material);
  EXPECT_GT(mean_difference(), 0.3) << "cells of 30 degrees";
}

TEST(DrawMode, FlatHasOneShadeATriangle)
{
  view::Scene scene = test::dark_scene();
  scene.lighting.sky = {1, 1, 1};
  scene.lighting.ground = {0, 0, 0};
  Material material = test::plain({0.8F, 0.8F, 0.8F});
  test::add(scene, test::ball(20, 6, 8), material);
  const auto shades = [&](view::DrawMode mode) {
    scene.mode = mode;
    const view::Image image = test::drawn(scene, test::camera_at(150), {width, height, 1});
    std::set<int> found;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) found.insert(at(image, x, y)[0]);
    }
    return found.size();
  };
  // Lit from above there is one shade per ring: six rings with 4 visible on the sides, at most doubled by
  // their triangles, each with a neighbouring code by rounding; and black.
  EXPECT_LE(shades(view::DrawMode::flat), 25U);
  EXPECT_GT(shades(view::DrawMode::smooth), 50U);
}

TEST(DrawMode, OnlyTexturedHasAPattern)
{
  view::Scene scene = test::dark_scene();
  Material material = test::plain({0.5F, 0.5F, 0.5F});
  material.mottling = 0.2F;
  test::add(scene, test::facing_sheet(400), material);
  scene.mode = view::DrawMode::smooth;
  const view::Image smooth = test::drawn(scene, test::camera_at(400));
  EXPECT_EQ(n_pixels(smooth, at(smooth, 0, 0)), width * height);
  scene.mode = view::DrawMode::textured;
  const view::Image textured = test::drawn(scene, test::camera_at(400));
  EXPECT_LT(n_pixels(textured, at(textured, 0, 0)), width * height / 2);
}

TEST(DrawMode, ATextureRepeatsAsWideAsItSays)
{
  view::Scene scene = test::dark_scene();
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
  const view::Image image = test::drawn(scene, test::camera_at(400));
  // 120 pixels are 100 mm; the image centre is mesh X = 0, where a tile starts.
  for (const int repeat : {-1, 0, 1}) {
    expect_near(at(image, width / 2 + 120 * repeat + 30, 50), {255, 0, 0, 255});
    if (repeat < 1) {
      expect_near(at(image, width / 2 + 120 * repeat + 90, 50), {0, 0, 255, 255});
    }
  }
}

TEST(Colours, ReplaceTheMaterialsAndBlendByTheirAlpha)
{
  view::Scene scene = square();
  scene.background = {};
  view::Drawable& sheet = scene.drawables[0];
  sheet.colours.assign(sheet.mesh.vertices.size(), {200, 100, 50, 255});
  expect_near(at(test::drawn(scene, test::camera_at(120)), width / 2 + 9, height / 2 + 5),
              {200, 100, 50, 255});
  sheet.colours.assign(sheet.mesh.vertices.size(), {200, 100, 50, 51});
  const auto part = [](int code) { return srgb_code(0.2 * test::linear_value(code)); };
  expect_near(at(test::drawn(scene, test::camera_at(120)), width / 2 + 9, height / 2 + 5),
              {part(200), part(100), part(50), 255});
}

TEST(Revision, ChangesAreSeenOnceTheNumberIsRaised)
{
  view::Scene scene = square();
  scene.background = {};
  const view::Camera camera = test::camera_at(120);
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height});
  renderer->load(scene);
  const auto middle = [&] { return at(renderer->draw(scene, camera), width / 2 + 9, height / 2 + 5); };
  EXPECT_EQ(middle(), white);
  view::Drawable& sheet = scene.drawables[0];
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

TEST(Shown, HiddenDrawablesLeaveNothing)
{
  view::Scene scene = square();
  scene.drawables[0].is_shown = false;
  for (const view::DrawMode mode :
       {view::DrawMode::wire, view::DrawMode::hidden_line, view::DrawMode::flat, view::DrawMode::textured}) {
    scene.mode = mode;
    const view::Image image = test::drawn(scene, test::camera_at(120));
    EXPECT_EQ(n_pixels(image, at(image, 0, 0)), width * height);
  }
}

TEST(Shots, EachHasItsPartOfThePicture)
{
  view::Scene scene = square();
  scene.background = {{0, 0, 1}, {0, 0, 1}};
  // The second overlaps the first and covers it because it is drawn later.
  const std::array<view::Shot, 2> shots{view::Shot{test::camera_at(60), {0, 0, 160, 240}},
                                        view::Shot{test::camera_at(240), {100, 60, 160, 120}}};
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height});
  renderer->load(scene);
  const view::Image& image = renderer->draw(scene, shots, nullptr);
  constexpr Codes blue{0, 0, 255, 255}, nothing{0, 0, 0, 255};
  EXPECT_EQ(at(image, 50, 120), white);
  EXPECT_EQ(at(image, 50, 5), white);     // 160 pixels are 60 mm: taller than the shot
  EXPECT_EQ(at(image, 102, 62), blue);    // a corner of the second, over the first
  EXPECT_EQ(at(image, 180, 120), white);  // its middle
  EXPECT_EQ(at(image, 258, 178), blue);
  EXPECT_EQ(at(image, 261, 120), nothing);
  EXPECT_EQ(at(image, 180, 181), nothing);
}

TEST(Coarseness, HalfAPixelIsHardlySeen)
{
  view::Scene scene = test::dark_scene();
  scene.lighting = view::studio_lighting();
  test::add(scene, test::ball(20, 128, 256), test::plain({0.8F, 0.8F, 0.8F}));
  scene.mode = view::DrawMode::smooth;
  const view::Image whole = test::drawn(scene, test::camera_at(150), {width, height, 4, 0.0});
  const view::Image coarse = test::drawn(scene, test::camera_at(150), {width, height, 4, 0.5});
  EXPECT_NE(whole.rgba, coarse.rgba);  // simplification had an effect
  // The outline (2 pi 64 pixels) moves by up to half a pixel; elsewhere normals are interpolated over larger
  // triangles. A surface error e at radius r has a chord s = sqrt(8 e r), and interpolation along s changes a
  // normal by (s / r)^2 / 8 = e / r: 0.5 / 64, one or two codes.
  int n_changed = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int most = 0;
      for (std::size_t k = 0; k < 3; ++k)
        most = std::max(most, std::abs(at(whole, x, y)[k] - at(coarse, x, y)[k]));
      n_changed += most > 4 ? 1 : 0;
    }
  }
  EXPECT_LE(n_changed, 2 * 403);
}

TEST(Resize, DrawsAsIfMadeSo)
{
  const view::Scene scene = test::joint_scene();
  const view::Camera camera = test::joint_camera(scene);
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({64, 48});
  renderer->load(scene);
  renderer->draw(scene, camera);
  renderer->resize(width, height);
  EXPECT_EQ(renderer->width(), width);
  EXPECT_EQ(renderer->height(), height);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, test::drawn(scene, camera).rgba);
  EXPECT_THROW(renderer->resize(0, 10), InputError);
  EXPECT_EQ(renderer->draw(scene, camera).rgba, test::drawn(scene, camera).rgba);
}

}  // namespace vrda::modes_test
