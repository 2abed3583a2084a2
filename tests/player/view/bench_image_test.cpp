// The frame buffer of the bench, checked by pixels.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "player/view/pictures.hpp"
#include "player/view/sample_eyes.hpp"
#include "view/eye.hpp"
#include "view/stereo_view.hpp"

namespace vrda::bench_picture_test {

using namespace test;

constexpr int display_width = 1280, display_height = 1024;
constexpr double promised_px = 0.05;

/// Both eyes of the thesis's layout with the same optics.
view::EyePair sample_eyes(const Optics& lens)
{
  view::EyePair eyes{sample_eye(lens.k1, lens.k2), sample_eye(lens.k1, lens.k2)};
  for (view::Viewport* v : {&eyes.left.window, &eyes.left.visible}) v->y -= 528;
  eyes.left.sight_px.y() -= 528.0;
  eyes.left.distortion.centre_px.y() -= 528.0;
  view::set_ipd(eyes, 64.0);
  return eyes;
}

/// Centroid of the light within `part`.
Eigen::Vector2d centre_of_light_px(const view::Image& image, const view::Viewport& part)
{
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double light = 0.0;
  for (int y = part.y; y < part.y + part.height; ++y) {
    for (int x = part.x; x < part.x + part.width; ++x) {
      const double value = linear_value(at(image, x, y)[0]);
      sum += value * Eigen::Vector2d(x + 0.5, y + 0.5);
      light += value;
    }
  }
  return sum / light;
}

constexpr double spot_px = 12.0;  // radius, before distortion

/// A disc that faces the eyes, white in the middle and black at the rim, so that there is no edge to be
/// missed by samples.
void add_spot(view::Scene& scene, const Eigen::Vector3d& p_mm)
{
  constexpr Eigen::Index n = 64;
  const double radius_mm = spot_px * -p_mm.z() / 880.0;
  Mesh disc;
  disc.vertices_mm = Points::Zero(n + 1, 3);
  disc.triangles.resize(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double angle_rad = 2.0 * pi * static_cast<double>(k) / static_cast<double>(n);
    disc.vertices_mm.row(k + 1) << radius_mm * std::cos(angle_rad), radius_mm * std::sin(angle_rad), 0.0;
    disc.triangles.row(k) << 0, static_cast<int>(k + 1), static_cast<int>((k + 1) % n + 1);
  }
  add(scene, disc, plain({1, 1, 1}), p_mm);
  view::Drawable& spot = scene.drawables.back();
  for (const RenderVertex& v : spot.mesh.vertices) {
    const std::uint8_t code = std::hypot(v.position_mm[0], v.position_mm[1]) < 0.5 * radius_mm ? 255 : 0;
    spot.colours.push_back({code, code, code, 255});
  }
}

/// Expected centroid of the drawn spot: the curvature of the distortion within the spot shifts it by some
/// hundredths of a pixel from the drawn centre.
Eigen::Vector2d spot_centre_px(const view::Eye& eye, const Eigen::Vector3d& p_mm)
{
  const Eigen::Vector2d middle = view::shown_px(eye, p_mm), drawn = view::drawn_px(eye, p_mm);
  const double radius_px = spot_px * -p_mm.z() / (eye.position_head_mm.z() - p_mm.z());
  constexpr double reach_px = 20.0, step_px = 0.125;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double light = 0.0;
  for (double x = -reach_px; x <= reach_px; x += step_px) {
    for (double y = -reach_px; y <= reach_px; y += step_px) {
      const Eigen::Vector2d at_px = drawn + Eigen::Vector2d(x, y);
      const Eigen::Vector2d off = view::shown_px(eye.distortion, at_px) - middle;
      const double value = std::max(0.0, 1.0 - std::hypot(off.x(), eye.pixel_aspect * off.y()) / radius_px);
      sum += value * at_px;
      light += value;
    }
  }
  return sum / light;
}

view::Image frame_of(const view::EyePair& eyes, const view::Scene& scene, const Pose& X_world_head)
{
  const view::StereoPlan plan = view::stereo_plan(eyes, display_width, display_height, "bench.toml");
  const auto renderer = view::make_offscreen_renderer({plan.width, plan.height, 4});
  renderer->load(scene);
  renderer->load(plan.warp);
  const std::array<view::Shot, 2> shots = view::shots_of(plan, eyes, X_world_head, scene);
  return renderer->draw(scene, shots, nullptr);
}

TEST(BenchPicture, APointIsDrawnAtItsPixelInEachEye)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> sideways(-0.14, 0.14), depth_mm(600.0, 1000.0);
  for (const Optics& lens : lenses) {
    const view::EyePair eyes = sample_eyes(lens);
    for (int n = 0; n < 4; ++n) {
      const double z = depth_mm(random);
      const Eigen::Vector3d p(z * sideways(random), z * sideways(random), -z);
      SCOPED_TRACE(testing::Message() << "k1 " << lens.k1 << " at " << p.transpose());
      view::Scene scene = dark_scene();
      add_spot(scene, p);
      const view::Image frame = frame_of(eyes, scene, Pose::Identity());
      EXPECT_LT((spot_centre_px(eyes.left, p) - view::drawn_px(eyes.left, p)).norm(), 0.1);
      EXPECT_LT((centre_of_light_px(frame, eyes.left.visible) - spot_centre_px(eyes.left, p)).norm(),
                promised_px);
      EXPECT_LT((centre_of_light_px(frame, eyes.right.visible) - spot_centre_px(eyes.right, p)).norm(),
                promised_px);
    }
  }
}

TEST(BenchPicture, OutsideOfWhatTheScreensShowAllIsBlack)
{
  const view::EyePair eyes = sample_eyes(lenses[1]);
  view::Scene scene = dark_scene();
  scene.background = {{1, 1, 1}, {1, 1, 1}};
  add(scene, facing_sheet(10), plain({1, 1, 1}), {0, 0, -700});
  const view::Image frame = frame_of(eyes, scene, Pose::Identity());
  int n_lit = 0, n_dark = 0, n_wrong = 0;
  for (int y = 0; y < display_height; ++y) {
    for (int x = 0; x < display_width; ++x) {
      const view::Viewport pixel{x, y, 1, 1};
      const bool is_visible =
          view::within(pixel, eyes.left.visible).width + view::within(pixel, eyes.right.visible).width > 0;
      const int code = at(frame, x, y)[1];
      (is_visible ? n_lit : n_dark) += 1;
      n_wrong += code == (is_visible ? 255 : 0) ? 0 : 1;
    }
  }
  EXPECT_EQ(n_lit, 2 * 590 * 440);
  EXPECT_GT(n_dark, 0);
  EXPECT_EQ(n_wrong, 0);
}

TEST(BenchPicture, EveryPictureHidesWhatLiesBehind)
{
  const view::EyePair eyes = sample_eyes(lenses[1]);
  view::Scene scene = dark_scene();
  scene.background = {};
  add(scene, facing_sheet(10), plain({1, 0, 0}), {0, 0, -700});
  add(scene, facing_sheet(10), plain({0, 1, 0}), {0, 0, -900});
  const view::StereoPlan plan = view::stereo_plan(eyes, display_width, display_height, "bench.toml");
  const auto renderer = view::make_offscreen_renderer({plan.width, plan.height, 1});
  renderer->load(scene);
  renderer->load(plan.warp);
  const std::array<view::Shot, 2> shots = view::shots_of(plan, eyes, Pose::Identity(), scene);
  const std::vector<std::uint8_t> first = renderer->draw(scene, shots, nullptr).rgba;
  const view::Image& second = renderer->draw(scene, shots, nullptr);
  EXPECT_EQ(second.rgba, first);
  for (const view::Eye* eye : {&eyes.left, &eyes.right}) {
    const Eigen::Vector2i middle = view::drawn_px(*eye, {0, 0, -700}).cast<int>();
    EXPECT_GT(at(second, middle.x(), middle.y())[0], 0);
    EXPECT_EQ(at(second, middle.x(), middle.y())[1], 0);
  }
}

TEST(BenchPicture, SwappingTheEyesAndMovingTheStageMovesPointsByTheComputedAmount)
{
  view::EyePair eyes = sample_eyes(lenses[0]);
  const Eigen::Vector3d p(15.0, -10.0, -804.0);
  view::Scene scene = dark_scene();
  add_spot(scene, p);
  Pose X_world_head = Pose::Identity();
  const Eigen::Vector2d there = centre_of_light_px(frame_of(eyes, scene, X_world_head), eyes.left.visible);
  X_world_head.translation().x() = 20.0;
  const Eigen::Vector2d moved = centre_of_light_px(frame_of(eyes, scene, X_world_head), eyes.left.visible);
  EXPECT_NEAR(moved.x() - there.x(), -880.0 * 20.0 / 800.0, promised_px);
  EXPECT_NEAR(moved.y() - there.y(), 0.0, promised_px);
  view::set_ipd(eyes, -64.0);
  const Eigen::Vector2d swapped =
      centre_of_light_px(frame_of(eyes, scene, Pose::Identity()), eyes.left.visible);
  EXPECT_NEAR(swapped.x() - there.x(), -880.0 * 64.0 / 800.0, promised_px);
}

/// A mirror or an inverted display in front of the eye shows what is drawn without one.
TEST(BenchPicture, AReflectedWindowHasTheSamePictureReversed)
{
  const view::EyePair eyes = sample_eyes(lenses[1]);
  view::Scene scene = dark_scene();
  add_spot(scene, {25.0, -12.0, -700.0});
  const auto drawn = [&](const view::Reflection& reflection) {
    const view::StereoPlan plan =
        view::stereo_plan(eyes, display_width, display_height, "bench.toml", reflection);
    const auto renderer = view::make_offscreen_renderer({plan.width, plan.height, 4});
    renderer->load(scene);
    renderer->load(plan.warp);
    return renderer->draw(scene, view::shots_of(plan, eyes, Pose::Identity(), scene), nullptr);
  };
  const view::Image plain = drawn({});
  for (const view::Reflection reflection :
       {view::Reflection{true, false}, view::Reflection{false, true}, view::Reflection{true, true}}) {
    const view::Image reversed = drawn(reflection);
    for (const view::Eye* eye : {&eyes.left, &eyes.right}) {
      const Eigen::Vector2d there = centre_of_light_px(plain, eye->visible);
      const Eigen::Vector2d wanted =
          view::reflected_px(reflection, eye->window, there.cast<float>()).cast<double>();
      // The window of the other eye is not touched, and the spot is not in the middle.
      EXPECT_LT((centre_of_light_px(reversed, eye->window) - wanted).norm(), promised_px);
      EXPECT_GT((there - wanted).norm(), 10.0);
    }
  }
}

/// Only what changed is cleared, resolved and warped; the frames are those of a renderer that begins with
/// them.
TEST(BenchPicture, AFrameDoesNotDependOnTheOnesBefore)
{
  const view::EyePair eyes = sample_eyes(lenses[1]);
  const view::StereoPlan plan = view::stereo_plan(eyes, display_width, display_height, "bench.toml");
  view::Scene scene = dark_scene();
  scene.background = {};
  add_spot(scene, {0.0, 0.0, -700.0});
  add_spot(scene, {0.0, 0.0, -900.0});
  const auto opened = [&](int samples) {
    auto renderer = view::make_offscreen_renderer({plan.width, plan.height, samples});
    renderer->load(scene);
    renderer->load(plan.warp);
    return renderer;
  };
  const auto drawn = [&](view::Renderer& renderer) {
    return renderer.draw(scene, view::shots_of(plan, eyes, Pose::Identity(), scene), nullptr).rgba;
  };
  std::mt19937 random(8);
  std::uniform_real_distribution<double> mm(-100.0, 100.0);
  for (const int samples : {1, 4}) {
    const auto moving = opened(samples);
    std::vector<std::uint8_t> before;
    for (int n = 0; n < 4; ++n) {
      SCOPED_TRACE(testing::Message() << samples << " samples, frame " << n);
      for (view::Drawable& drawable : scene.drawables)
        drawable.X_world_mesh.translation().head<2>() = Eigen::Vector2d(mm(random), mm(random));
      scene.drawables[0].is_shown = n != 2;
      const std::vector<std::uint8_t> now = drawn(*moving);
      EXPECT_TRUE(now == drawn(*opened(samples)));
      EXPECT_FALSE(now == before);
      before = now;
    }
    for (view::Drawable& drawable : scene.drawables) drawable.is_shown = false;
    EXPECT_TRUE(drawn(*moving) == drawn(*opened(samples))) << "nothing is shown";
    for (view::Drawable& drawable : scene.drawables) drawable.is_shown = true;
  }
}

}  // namespace vrda::bench_picture_test
