#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "core/text.hpp"
#include "player/view/pictures.hpp"

namespace vrda::view::overlay_test {

using test::at;
using test::Codes;

constexpr int width = 64, height = 48;

/// Coverage 1 in the left half and 0 in the right; the first column is used for areas.
OverlayFont half_font()
{
  return {4, 2, {255, 255, 0, 0, 255, 255, 0, 0}};
}

struct Area {
  float left, top, right, bottom;
};

void add(Overlay& overlay, const Area& area, const VertexColour& colour, const Area& font = {0, 0, 0, 0})
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

Image drawn(const Overlay& overlay, const Scene& scene = test::dark_scene(), int samples = 4)
{
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height, samples});
  renderer->load(scene);
  renderer->load(half_font());
  const Shot shot{test::camera_at(100), {0, 0, width, height}};
  return renderer->draw(scene, {&shot, 1}, &overlay);
}

TEST(Overlay, Clipping)
{
  Overlay overlay;
  add(overlay, {0, 0, width, height}, {255, 255, 255, 255});
  overlay.commands[0].clip_px = {10, 5, 20, 30};
  const Image image = drawn(overlay);
  EXPECT_EQ(at(image, 10, 5)[0], 255);
  EXPECT_EQ(at(image, 19, 29)[0], 255);
  EXPECT_EQ(at(image, 9, 5)[0], 0);
  EXPECT_EQ(at(image, 20, 29)[0], 0);
  EXPECT_EQ(at(image, 10, 4)[0], 0);
  EXPECT_EQ(at(image, 19, 30)[0], 0);
}

// Glyphs cover by their font and blend in linear light.
TEST(Overlay, Glyphs)
{
  Scene scene = test::dark_scene();
  scene.background = {{0.2F, 0.2F, 0.2F}, {0.2F, 0.2F, 0.2F}};
  Overlay overlay;
  add(overlay, {0, 0, 64, 48}, {255, 255, 255, 128}, {0, 0, 1, 1});
  const Image image = drawn(overlay, scene);
  const int blended = test::srgb_code(0.2 + (1.0 - 0.2) * 128.0 / 255.0);
  EXPECT_NEAR(at(image, 8, 20)[1], blended, test::code_tolerance);
  EXPECT_NEAR(at(image, 56, 20)[1], test::srgb_code(0.2), test::code_tolerance);
}

TEST(Overlay, AFontComesFirst)
{
  Overlay overlay;
  add(overlay, {0, 0, 20, 20}, {255, 0, 0, 255});
  const Scene scene = test::dark_scene();
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer({width, height});
  renderer->load(scene);
  const Shot shot{test::camera_at(100), {0, 0, width, height}};
  EXPECT_THROW(renderer->draw(scene, {&shot, 1}, &overlay), InternalError);
  EXPECT_THROW(renderer->load(OverlayFont{2, 2, {1, 2, 3}}), InternalError);
}

}  // namespace vrda::view::overlay_test
