// The frame buffer of the bench, checked by pixels.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "player/view/pictures.hpp"
#include "player/view/sample_eyes.hpp"
#include "view/eye.hpp"
#include "view/stereo_view.hpp"

namespace vrda::view::bench_picture_test {

using namespace test;

constexpr int display_width = 1280, display_height = 1024;
constexpr double promised_px = 0.05;

/// Both eyes of the thesis's layout with the same optics.
EyePair sample_eyes(const Optics& lens)
{
  EyePair eyes{sample_eye(lens.k1, lens.k2), sample_eye(lens.k1, lens.k2)};
  for (Viewport* v : {&eyes.left.window, &eyes.left.visible}) v->y -= 528;
  eyes.left.sight_px.y() -= 528.0;
  eyes.left.distortion.centre_px.y() -= 528.0;
  set_ipd(eyes, 64.0);
  return eyes;
}

/// Centroid of the light within `part`.
Eigen::Vector2d centre_of_light_px(const Image& image, const Viewport& part)
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
void add_spot(Scene& scene, const Eigen::Vector3d& p_mm)
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
  Drawable& spot = scene.drawables.back();
  for (const RenderVertex& v : spot.mesh.vertices) {
    const std::uint8_t code = std::hypot(v.position_mm[0], v.position_mm[1]) < 0.5 * radius_mm ? 255 : 0;
    spot.colours.push_back({code, code, code, 255});
  }
}

/// Expected centroid of the drawn spot: the curvature of the distortion within the spot shifts it by some
/// hundredths of a pixel from the drawn centre.
Eigen::Vector2d spot_centre_px(const Eye& eye, const Eigen::Vector3d& p_mm)
{
  const Eigen::Vector2d middle = shown_px(eye, p_mm), drawn = drawn_px(eye, p_mm);
  const double radius_px = spot_px * -p_mm.z() / (eye.position_head_mm.z() - p_mm.z());
  constexpr double reach_px = 20.0, step_px = 0.125;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double light = 0.0;
  for (double x = -reach_px; x <= reach_px; x += step_px) {
    for (double y = -reach_px; y <= reach_px; y += step_px) {
      const Eigen::Vector2d at_px = drawn + Eigen::Vector2d(x, y);
      const Eigen::Vector2d off = shown_px(eye.distortion, at_px) - middle;
      const double value = std::max(0.0, 1.0 - std::hypot(off.x(), eye.pixel_aspect * off.y()) / radius_px);
      sum += value * at_px;
      light += value;
    }
  }
  return sum / light;
}

Image frame_of(const EyePair& eyes, const Scene& scene, const Pose& X_world_head)
{
  const StereoPlan plan = stereo_plan(eyes, display_width, display_height, "bench.toml");
  const auto renderer = make_offscreen_renderer({plan.width, plan.height, 4});
  renderer->load(scene);
  renderer->load(plan.warp);
  const std::array<Shot, 2> shots = shots_of(plan, eyes, X_world_head, scene);
  return renderer->draw(scene, shots, nullptr);
}

TEST(BenchPicture, PixelOfAPoint)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> sideways(-0.14, 0.14), depth_mm(600.0, 1000.0);
  for (const Optics& lens : lenses) {
    const EyePair eyes = sample_eyes(lens);
    for (int n = 0; n < 4; ++n) {
      const double z = depth_mm(random);
      const Eigen::Vector3d p(z * sideways(random), z * sideways(random), -z);
      SCOPED_TRACE(testing::Message() << "k1 " << lens.k1 << " at " << p.transpose());
      Scene scene = dark_scene();
      add_spot(scene, p);
      const Image frame = frame_of(eyes, scene, Pose::Identity());
      EXPECT_LT((spot_centre_px(eyes.left, p) - drawn_px(eyes.left, p)).norm(), 0.1);
      EXPECT_LT((centre_of_light_px(frame, eyes.left.visible) - spot_centre_px(eyes.left, p)).norm(),
                promised_px);
      EXPECT_LT((centre_of_light_px(frame, eyes.right.visible) - spot_centre_px(eyes.right, p)).norm(),
                promised_px);
    }
  }
}

/// A mirror or an inverted display in front of the eye shows what is drawn without one.
TEST(BenchPicture, Reflection)
{
  const EyePair eyes = sample_eyes(lenses[1]);
  Scene scene = dark_scene();
  add_spot(scene, {25.0, -12.0, -700.0});
  const auto drawn = [&](const Reflection& reflection) {
    const StereoPlan plan = stereo_plan(eyes, display_width, display_height, "bench.toml", reflection);
    const auto renderer = make_offscreen_renderer({plan.width, plan.height, 4});
    renderer->load(scene);
    renderer->load(plan.warp);
    return renderer->draw(scene, shots_of(plan, eyes, Pose::Identity(), scene), nullptr);
  };
  const Image plain = drawn({});
  for (const Reflection reflection :
       {Reflection{true, false}, Reflection{false, true}, Reflection{true, true}}) {
    const Image reversed = drawn(reflection);
    for (const Eye* eye : {&eyes.left, &eyes.right}) {
      const Eigen::Vector2d there = centre_of_light_px(plain, eye->visible);
      const Eigen::Vector2d wanted =
          reflected_px(reflection, eye->window, there.cast<float>()).cast<double>();
      // The window of the other eye is not touched, and the spot is not in the middle.
      EXPECT_LT((centre_of_light_px(reversed, eye->window) - wanted).norm(), promised_px);
      EXPECT_GT((there - wanted).norm(), 10.0);
    }
  }
}

/// Only what changed is cleared, resolved and warped; the frames are those of a renderer that begins with
/// them.
TEST(BenchPicture, FramesAreIndependent)
{
  const EyePair eyes = sample_eyes(lenses[1]);
  const StereoPlan plan = stereo_plan(eyes, display_width, display_height, "bench.toml");
  Scene scene = dark_scene();
  scene.background = {};
  add_spot(scene, {0.0, 0.0, -700.0});
  add_spot(scene, {0.0, 0.0, -900.0});
  const auto opened = [&](int samples) {
    auto renderer = make_offscreen_renderer({plan.width, plan.height, samples});
    renderer->load(scene);
    renderer->load(plan.warp);
    return renderer;
  };
  const auto drawn = [&](Renderer& renderer) {
    return renderer.draw(scene, shots_of(plan, eyes, Pose::Identity(), scene), nullptr).rgba;
  };
  std::mt19937 random(8);
  std::uniform_real_distribution<double> mm(-100.0, 100.0);
  for (const int samples : {1, 4}) {
    const auto moving = opened(samples);
    std::vector<std::uint8_t> before;
    for (int n = 0; n < 4; ++n) {
      SCOPED_TRACE(testing::Message() << samples << " samples, frame " << n);
      for (Drawable& drawable : scene.drawables)
        drawable.X_world_mesh.translation().head<2>() = Eigen::Vector2d(mm(random), mm(random));
      scene.drawables[0].is_shown = n != 2;
      const std::vector<std::uint8_t> now = drawn(*moving);
      EXPECT_TRUE(now == drawn(*opened(samples)));
      EXPECT_FALSE(now == before);
      before = now;
    }
    for (Drawable& drawable : scene.drawables) drawable.is_shown = false;
    EXPECT_TRUE(drawn(*moving) == drawn(*opened(samples))) << "nothing is shown";
    for (Drawable& drawable : scene.drawables) drawable.is_shown = true;
  }
}

}  // namespace vrda::view::bench_picture_test
