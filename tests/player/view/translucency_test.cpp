#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "model/frames.hpp"
#include "player/view/pictures.hpp"
#include "support/meshes.hpp"

namespace vrda::view::translucency_test {

constexpr int width = 320, height = 240;
constexpr double distance_mm = 200.0;

struct Sheet {
  Eigen::Vector3d middle_mm;
  double tilt_rad;  ///< about the world's Y
  Eigen::Vector3f colour;
  float opacity;
};

/// Depth along the camera axis of the intersection of the ray through (x, y, -1) with the sheet's plane.
double depth_mm(const Sheet& sheet, const Eigen::Vector3d& ray)
{
  const Eigen::Vector3d normal = rotation_y(sheet.tilt_rad) * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d eye(0, 0, distance_mm);
  return (sheet.middle_mm - eye).dot(normal) / ray.dot(normal);
}

/// Blending by "over" from the farthest sheet; each sheet extends beyond the image.
Eigen::Array3d expected_colour(std::vector<Sheet> sheets, const Eigen::Vector3d& ray)
{
  std::ranges::sort(sheets,
                    [&](const Sheet& a, const Sheet& b) { return depth_mm(a, ray) > depth_mm(b, ray); });
  Eigen::Array3d colour = Eigen::Array3d::Zero();
  for (const Sheet& sheet : sheets) {
    const double opacity = sheet.opacity;
    colour = (1.0 - opacity) * colour + opacity * sheet.colour.array().cast<double>();
  }
  return colour;
}

/// For each sheet the number of sheets in front of it.
using Order = std::vector<std::ptrdiff_t>;

Order order_of(const std::vector<Sheet>& sheets, const Eigen::Vector3d& ray)
{
  Order order;
  order.reserve(sheets.size());
  for (const Sheet& sheet : sheets) {
    order.push_back(std::ranges::count_if(
        sheets, [&](const Sheet& other) { return depth_mm(other, ray) < depth_mm(sheet, ray); }));
  }
  return order;
}

Scene scene_of_sheets(const std::vector<Sheet>& sheets)
{
  Scene scene = test::dark_scene();
  for (const Sheet& sheet : sheets) {
    test::add(scene, test::facing_sheet(600), test::plain(sheet.colour, sheet.opacity), sheet.middle_mm);
    scene.drawables.back().X_world_mesh.linear() = rotation_y(sheet.tilt_rad);
  }
  return scene;
}

/// The blended colour is rounded to a code after each sheet, and each rounding error is attenuated by the
/// sheets in front: at opacity 0.4 or more the sum is below 1 / 0.4 codes.
constexpr int sheets_tolerance = 3;

void expect_as_computed(const std::vector<Sheet>& sheets, int samples, std::set<Order>& orders)
{
  const Image image =
      test::drawn(scene_of_sheets(sheets), test::camera_at(distance_mm), {width, height, samples});
  const double slope = 2.0 * 0.25 / height;  // ray slope per pixel; the camera's aspect is 4 : 3
  int n_wrong = 0;
  for (int y = 0; y < height; y += 7) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d ray((x + 0.5 - 0.5 * width) * slope, (0.5 * height - y - 0.5) * slope, -1.0);
      const Eigen::Vector3d left = ray - Eigen::Vector3d(slope, 0, 0),
                            right = ray + Eigen::Vector3d(slope, 0, 0);
      // Where sheets intersect, a pixel has samples of both orders.
      const bool has_one_order = order_of(sheets, left) == order_of(sheets, right);
      orders.insert(order_of(sheets, ray));
      const Eigen::Array3d expected = expected_colour(sheets, ray);
      const test::Codes found = test::at(image, x, y);
      bool is_right = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const int code = test::srgb_code(expected[static_cast<Eigen::Index>(k)]);
        is_right = is_right && std::abs(found[k] - code) <= sheets_tolerance;
      }
      n_wrong += has_one_order && !is_right ? 1 : 0;
    }
  }
  EXPECT_EQ(n_wrong, 0);
}

// Sheets that pass through each other blend in the order of each pixel.
TEST(Translucency, CrossingSheets)
{
  const std::vector<Sheet> sheets{{{0, 0, 5}, 0.5, {1, 0, 0}, 0.4F},
                                  {{10, 0, 0}, -0.5, {0, 1, 0}, 0.5F},
                                  {{0, 0, 0}, 0.0, {0, 0, 1}, 0.6F},
                                  {{-20, 0, 0}, 0.2, {1, 1, 0}, 0.4F}};
  std::vector<std::size_t> loaded{0, 1, 2, 3};
  std::set<Order> orders;
  for (const int samples : {1, 4}) {
    for (int turn = 0; turn < 4; ++turn) {
      std::rotate(loaded.begin(), loaded.begin() + 1, loaded.end());
      std::vector<Sheet> turned;
      for (const std::size_t i : loaded) turned.push_back(sheets[i]);
      SCOPED_TRACE(testing::Message() << samples << " samples, turn " << turn);
      expect_as_computed(turned, samples, orders);
    }
  }
  EXPECT_GE(orders.size(), 4U * 5U);  // at least five orders from left to right for each permutation
}

// Of a structure only the nearest surface counts, in front of those of others.
TEST(Translucency, InsideOfAStructure)
{
  for (const int samples : {1, 4}) {
    Scene scene = scene_of_sheets({{{0, 0, -10}, 0.0, {1, 0, 0}, 0.5F},
                                   {{0, 0, 10}, 0.0, {1, 0, 0}, 0.5F},
                                   {{0, 0, 0}, 0.0, {0, 1, 0}, 0.5F}});
    scene.drawables[0].structure = scene.drawables[1].structure = "bone";
    scene.drawables[2].structure = "meniscus";
    const Image image = test::drawn(scene, test::camera_at(distance_mm), {width, height, samples});
    const test::Codes found = test::at(image, width / 2, height / 2);
    EXPECT_NEAR(found[0], test::srgb_code(0.5), sheets_tolerance) << samples;
    EXPECT_NEAR(found[1], test::srgb_code(0.25), sheets_tolerance) << samples;
  }
}

/// Eight sheets that cover an image of `large` pixels: with llvmpipe more fragments than a buffer holds.
TEST(Translucency, ManyFragments)
{
  const RenderOptions large{1280, 960, 1};
  const int n_sheets = 8;
  Scene scene = test::dark_scene();
  double expected = 0.0;
  for (int i = 0; i < n_sheets; ++i) {
    const float shade = i % 2 == 0 ? 1.0F : 0.0F;
    const int place = 3 * i % n_sheets;
    test::add(scene, test::facing_sheet(600), test::plain({place % 2 == 0 ? 1.0F : 0.0F, 0, 0}, 0.4F),
              {0, 0, 3.0 * place});
    expected = 0.6 * expected + 0.4 * shade;
  }
  const std::unique_ptr<Renderer> renderer = make_offscreen_renderer(large);
  renderer->load(scene);
  for (int frame = 0; frame < 2; ++frame) {
    const Image& image = renderer->draw(scene, test::camera_at(distance_mm));
    for (const int x : {0, 640, 1279}) {
      EXPECT_NEAR(test::at(image, x, 3)[0], test::srgb_code(expected), sheets_tolerance);
      EXPECT_NEAR(test::at(image, x, 957)[0], test::srgb_code(expected), sheets_tolerance);
    }
  }
}

TEST(Translucency, BehindOpaque)
{
  Scene scene = test::dark_scene();
  test::add(scene, test::facing_sheet(600), test::plain({1, 0, 0}, 0.5F), {0, 0, -10});
  test::add(scene, test::facing_sheet(600), test::plain({0, 0, 1}));
  test::add(scene, test::facing_sheet(600), test::plain({0, 1, 0}, 0.5F), {0, 0, 10});
  const test::Codes found = test::at(test::drawn(scene, test::camera_at(distance_mm)), 30, 30);
  EXPECT_EQ(found[0], 0);
  EXPECT_NEAR(found[1], test::srgb_code(0.5), test::code_tolerance);
  EXPECT_NEAR(found[2], test::srgb_code(0.5), test::code_tolerance);
}

// A depth offset changes what hides a sheet and not its outline.
TEST(Translucency, DepthOffset)
{
  const auto red_at = [](double in_front_mm, int x) {
    Scene scene = test::dark_scene();
    test::add(scene, test::facing_sheet(40), test::plain({0, 0, 1}));
    test::add(scene, test::facing_sheet(80), test::plain({1, 0, 0}, 0.5F), {0, 0, in_front_mm});
    scene.drawables.back().depth_offset_mm = 10.0;
    return test::at(test::drawn(scene, test::camera_at(distance_mm)), x, height / 2)[0];
  };
  // The outline of the sheet at 0 mm: 80 mm are 192 of 320 pixels at the camera's distance.
  const int outside = width / 2 + 97, inside = width / 2 + 94, over_other = width / 2;
  EXPECT_EQ(red_at(0.0, outside), 0);
  EXPECT_NEAR(red_at(0.0, inside), test::srgb_code(0.5), test::code_tolerance);
  EXPECT_EQ(red_at(9.0, over_other), 0);
  EXPECT_NEAR(red_at(11.0, over_other), test::srgb_code(0.5), test::code_tolerance);
}

}  // namespace vrda::view::translucency_test
