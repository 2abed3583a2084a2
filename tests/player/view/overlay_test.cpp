#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "core/text.hpp"
#include "player/view/pictures.hpp"

namespace vrda::overlay_test {

using test::at;
using test::Codes;

constexpr int width = 64, height = 48;

/// Coverage 1 in the left half and 0 in the right; the first column is used for areas.
view::OverlayFont half_font()
{
  return {4, 2, {255, 255, 0, 0, 255, 255, 0, 0}};
}

struct Area {
  float left, top, right, bottom;
};

void add(view::Overlay& overlay, const Area& area, const view::VertexColour& colour,
         const Area& font = {0, 0, 0, 0})
{
  const auto first_vertex = static_cast<std::uint32_t>(overlay.vertices.size());
  const auto first_index = static_cast<std::uint32_t>(overlay.indices.size());
  overlay.vertices.push_back({area.left, area.top, font.left, font.top, colour});
  overlay.vertices.push_back({area.right, area.top, font.right, font.top, colour});
  overlay.vertices.push_back({area.right, area.bottom, font.right, font.bottom, colour});
  overlay.vertices.push_back({area.left, area.bottom, font.left, font.bottom, colour});
  overlay.indices.insert(overlay.indices.end(), {0, 1, 2, 0, 2, 3});
  overlay.commands.push_back({{0, 0, width, height}, first_index, 6, first_vertex});
}

view::Image drawn(const view::Overlay& overlay, const view::Scene& scene = test::dark_scene(),
                  int samples = 4)
{
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height, samples});
  renderer->load(scene);
  renderer->load(half_font());
  const view::Shot shot{test::camera_at(100), {0, 0, width, height}};
  return renderer->draw(scene, {&shot, 1}, &overlay);
}

bool is_near(const Codes& found, const Codes& expected)
{
  return std::equal(found.begin(), found.end(), expected.begin(),
                    [](int a, int b) { return std::abs(a - b) <= test::code_tolerance; });
}

TEST(Overlay, AnAreaCoversItsPixelsAndNoOthers)
{
  view::Overlay overlay;
  add(overlay, {10, 5, 20, 30}, {200, 100, 50, 255});
  for (const int samples : {1, 4}) {
    const view::Image image = drawn(overlay, test::dark_scene(), samples);
    int n_wrong = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool is_inside = x >= 10 && x < 20 && y >= 5 && y < 30;
        n_wrong +=
            is_near(at(image, x, y), is_inside ? Codes{200, 100, 50, 255} : Codes{0, 0, 0, 255}) ? 0 : 1;
      }
    }
    EXPECT_EQ(n_wrong, 0);
  }
}

TEST(Overlay, ItIsClippedToItsRectangle)
{
  view::Overlay overlay;
  add(overlay, {0, 0, width, height}, {255, 255, 255, 255});
  overlay.commands[0].clip_px = {10, 5, 20, 30};
  const view::Image image = drawn(overlay);
  EXPECT_EQ(at(image, 10, 5)[0], 255);
  EXPECT_EQ(at(image, 19, 29)[0], 255);
  EXPECT_EQ(at(image, 9, 5)[0], 0);
  EXPECT_EQ(at(image, 20, 29)[0], 0);
  EXPECT_EQ(at(image, 10, 4)[0], 0);
  EXPECT_EQ(at(image, 19, 30)[0], 0);
}

TEST(Overlay, GlyphsCoverByTheirFontAndBlendInLinearLight)
{
  view::Scene scene = test::dark_scene();
  scene.background = {{0.2F, 0.2F, 0.2F}, {0.2F, 0.2F, 0.2F}};
  view::Overlay overlay;
  add(overlay, {0, 0, 64, 48}, {255, 255, 255, 128}, {0, 0, 1, 1});
  const view::Image image = drawn(overlay, scene);
  const int blended = test::srgb_code(0.2 + (1.0 - 0.2) * 128.0 / 255.0);
  EXPECT_NEAR(at(image, 8, 20)[1], blended, test::code_tolerance);
  EXPECT_NEAR(at(image, 56, 20)[1], test::srgb_code(0.2), test::code_tolerance);
}

TEST(Overlay, CommandsHaveTheirOwnVerticesAndTheLastLiesOnTop)
{
  view::Overlay overlay;
  add(overlay, {0, 0, 20, 20}, {255, 0, 0, 255});
  add(overlay, {10, 10, 30, 30}, {0, 255, 0, 255});
  const view::Image image = drawn(overlay);
  EXPECT_EQ(at(image, 5, 5), (Codes{255, 0, 0, 255}));
  EXPECT_EQ(at(image, 15, 15), (Codes{0, 255, 0, 255}));
  EXPECT_EQ(at(image, 25, 25), (Codes{0, 255, 0, 255}));
}

TEST(Overlay, ItLiesOverTheSceneWhateverItsDepth)
{
  view::Scene scene = test::dark_scene();
  test::add(scene, test::facing_sheet(200), test::plain({1, 1, 1}));
  view::Overlay overlay;
  add(overlay, {0, 0, 20, 20}, {255, 0, 0, 255});
  EXPECT_EQ(at(drawn(overlay, scene), 5, 5), (Codes{255, 0, 0, 255}));
  EXPECT_EQ(at(drawn(overlay, scene), 40, 5), (Codes{255, 255, 255, 255}));
}

TEST(Overlay, AFontComesFirst)
{
  view::Overlay overlay;
  add(overlay, {0, 0, 20, 20}, {255, 0, 0, 255});
  const view::Scene scene = test::dark_scene();
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height});
  renderer->load(scene);
  const view::Shot shot{test::camera_at(100), {0, 0, width, height}};
  EXPECT_THROW(renderer->draw(scene, {&shot, 1}, &overlay), InternalError);
  EXPECT_THROW(renderer->load(view::OverlayFont{2, 2, {1, 2, 3}}), InternalError);
}

}  // namespace vrda::overlay_test
