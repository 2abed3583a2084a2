// The eyes of a bench: projection, distortion, and the pixels of its frame buffer.
#include <gtest/gtest.h>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "core/text.hpp"
#include "player/view/pictures.hpp"
#include "view/eye.hpp"
#include "view/stereo_view.hpp"

namespace vrda::view::stereo_test {

using namespace test;

/// The right eye of the thesis's layout: the lower right quarter, with a smaller, off-centre visible part.
Eye sample_eye(double k1 = 0.12, double k2 = 0.02)
{
  Eye eye;
  eye.window = {640, 544, 640, 480};
  eye.visible = {660, 560, 590, 440};
  eye.distance_px = 880.0;
  eye.pixel_aspect = 1.04;
  eye.sight_px = {957.3, 781.6};
  eye.position_head_mm = {32.0, 1.5, -4.0};
  eye.distortion = {k1, k2, {955.0, 780.0}, 320.0, 1.04};
  return eye;
}

struct Optics {
  double k1, k2;
};
constexpr Optics lenses[] = {{0.0, 0.0}, {0.12, 0.02}, {0.25, 0.0}, {-0.1, 0.01}};

constexpr double before_px = 1e-9;  // rounding at a thousand pixels
constexpr double after_px = 0.05;   // required; the mesh error is below 0.01

/// Position of the point in the image of `box` rendered by the camera.
Eigen::Vector2d pictured_px(const Camera& camera, const ShownBox& box, const Eigen::Vector3d& p_world_mm)
{
  const Eigen::Vector4d clip =
      projection(camera) * (camera.X_world_camera.inverse() * p_world_mm).homogeneous();
  const Eigen::Vector3d at = clip.hnormalized();
  const Eigen::Vector2d share(0.5 * (1.0 + at.x()), 0.5 * (1.0 - at.y()));
  return box.low_px + share.cwiseProduct(box.high_px - box.low_px);
}

/// A point within the visible part for the barrel and pincushion optics of the tests.
Eigen::Vector3d random_point_head_mm(std::mt19937& random)
{
  std::uniform_real_distribution<double> sideways(-0.2, 0.2), depth_mm(400.0, 1500.0);
  const double z = depth_mm(random);
  return {z * sideways(random), 0.8 * z * sideways(random), -z};
}

/// The position in the undistorted image that the mesh samples at `drawn_px`, by linear interpolation.
Eigen::Vector2d sampled_px(const WarpMesh& mesh, const ShownBox& box, const Eigen::Vector2d& drawn_px)
{
  const auto at = [&](std::uint32_t k) {
    return Eigen::Vector2d(mesh.vertices[k].x_px, mesh.vertices[k].y_px);
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
    Eigen::Matrix2d edges;
    edges << at(b) - at(a), at(c) - at(a);
    const Eigen::Vector2d weight = edges.inverse() * (drawn_px - at(a));
    constexpr double rounding = 1e-9;
    if (weight.minCoeff() < -rounding || weight.sum() > 1.0 + rounding) continue;
    const auto uv = [&](std::uint32_t k) { return Eigen::Vector2d(mesh.vertices[k].u, mesh.vertices[k].v); };
    const Eigen::Vector2d found = uv(a) + weight.x() * (uv(b) - uv(a)) + weight.y() * (uv(c) - uv(a));
    return box.low_px + found.cwiseProduct(box.high_px - box.low_px);
  }
  throw InternalError("a sampled point is within the visible part");
}

// A point lands on the computed pixel before and after distortion.
TEST(Eye, PixelOfAPoint)
{
  std::mt19937 random(1);
  for (const Optics& lens : lenses) {
    SCOPED_TRACE(testing::Message() << lens.k1 << " " << lens.k2);
    const Eye eye = sample_eye(lens.k1, lens.k2);
    const ShownBox box = shown_box(eye);
    const WarpMesh mesh = warp_mesh(eye, box);
    for (int n = 0; n < 200; ++n) {
      const Eigen::Vector3d p = random_point_head_mm(random);
      const Eigen::Vector3d from_eye = p - eye.position_head_mm;
      const Eigen::Vector2d expected(957.3 + 880.0 * from_eye.x() / -from_eye.z(),
                                     781.6 - 880.0 / 1.04 * from_eye.y() / -from_eye.z());
      const Camera camera = camera_of(eye, Pose::Identity(), box);
      EXPECT_LT((pictured_px(camera, box, p) - expected).norm(), before_px);
      EXPECT_LT((sampled_px(mesh, box, drawn_px(eye, p)) - expected).norm(), after_px);
    }
  }
}

// Moving the head the eye or the window moves the pixel by the computed amount.
TEST(Eye, MovedHeadAndWindow)
{
  const Eye eye = sample_eye();
  const Eigen::Vector3d p(40.0, -25.0, -804.0);  // 800 mm in front of the eye
  const Eigen::Vector2d there = shown_px(eye, p);

  Pose X_world_head = Pose::Identity();
  X_world_head.translation().x() = 60.0;  // the parallax stage
  const ShownBox box = shown_box(eye);
  const Eigen::Vector2d shifted = pictured_px(camera_of(eye, X_world_head, box), box, p);
  EXPECT_NEAR(shifted.x() - there.x(), -880.0 * 60.0 / 800.0, before_px);
  EXPECT_NEAR(shifted.y(), there.y(), before_px);

  Eye moved = eye;
  moved.window.x -= 640, moved.visible.x -= 640, moved.sight_px.x() -= 640.0,
      moved.distortion.centre_px.x() -= 640.0;
  EXPECT_LT((drawn_px(moved, p) - drawn_px(eye, p) - Eigen::Vector2d(-640.0, 0.0)).norm(), before_px);
}

TEST(Eye, Disparity)
{
  EyePair eyes{sample_eye(), sample_eye()};
  set_ipd(eyes, 63.0);
  const Eigen::Vector3d p(10.0, 5.0, -754.0);  // 750 mm in front of both
  const Eigen::Vector2d apart = shown_px(eyes.left, p) - shown_px(eyes.right, p);
  EXPECT_NEAR(apart.x(), 880.0 * 63.0 / 750.0, before_px);
  EXPECT_NEAR(apart.y(), 0.0, before_px);
  std::swap(eyes.left, eyes.right);
  EXPECT_NEAR((shown_px(eyes.left, p) - shown_px(eyes.right, p)).x(), -apart.x(), before_px);
}

TEST(Distortion, Inverse)
{
  std::mt19937 random(2);
  std::uniform_real_distribution<double> px(-300.0, 300.0);
  for (const Optics& lens : lenses) {
    const Distortion d = sample_eye(lens.k1, lens.k2).distortion;
    for (int n = 0; n < 500; ++n) {
      const Eigen::Vector2d p = d.centre_px + Eigen::Vector2d(px(random), px(random));
      EXPECT_LT((drawn_px(d, shown_px(d, p)) - p).norm(), before_px) << lens.k1 << " " << p.transpose();
    }
    EXPECT_EQ(shown_px(d, d.centre_px), d.centre_px);
  }
}

TEST(Distortion, Polynomial)
{
  const Distortion d{0.1, 0.03, {0.0, 0.0}, 200.0, 2.0};
  EXPECT_NEAR(shown_px(d, {100.0, 0.0}).x(), 100.0 * (1.0 + 0.1 * 0.25 + 0.03 * 0.0625), 1e-12);
  // Pixels are twice as high as wide: 50 vertical pixels are as far as 100 horizontal ones.
  EXPECT_NEAR(shown_px(d, {0.0, 50.0}).y(), 50.0 * (1.0 + 0.1 * 0.25 + 0.03 * 0.0625), 1e-12);
}

TEST(Distortion, Fold)
{
  constexpr double never = std::numeric_limits<double>::infinity();
  const auto fold = [](double k1, double k2) { return fold_radius_px({k1, k2, {0, 0}, 1.0, 1.0}); };
  EXPECT_EQ(fold(0.0, 0.0), never);
  EXPECT_EQ(fold(0.2, 0.1), never);
  EXPECT_EQ(fold(-0.1, 0.1), never);  // 0.09 < 4 * 0.5: the slope has no root
  EXPECT_NEAR(fold(-0.3, 0.0), std::sqrt(1.0 / 0.9), 1e-15);
  EXPECT_NEAR(fold(0.0, -0.2), 1.0, 1e-15);
  const double r = fold(0.3, -0.1), step = 1e-4;  // the slope changes sign there
  const auto slope = [](double at) { return 1.0 + 0.9 * at * at - 0.5 * at * at * at * at; };
  EXPECT_GT(slope(r - step), 0.0);
  EXPECT_LT(slope(r + step), 0.0);
}

TEST(Distortion, BeyondTheFold)
{
  const Distortion d{-0.3, 0.0, {0.0, 0.0}, 1.0, 1.0};
  EXPECT_NEAR(drawn_px(d, {5.0, 0.0}).x(), fold_radius_px(d), 1e-12);
}

// Covers the visible part and its picture exactly.
TEST(WarpMesh, Coverage)
{
  for (const Optics& lens : lenses) {
    const Eye eye = sample_eye(lens.k1, lens.k2);
    const WarpMesh mesh = warp_mesh(eye, shown_box(eye));
    float left = 1e9F, right = -1e9F, u_low = 1.0F, u_high = 0.0F, v_low = 1.0F, v_high = 0.0F;
    for (const WarpVertex& v : mesh.vertices) {
      left = std::min(left, v.x_px), right = std::max(right, v.x_px);
      u_low = std::min(u_low, v.u), u_high = std::max(u_high, v.u);
      v_low = std::min(v_low, v.v), v_high = std::max(v_high, v.v);
    }
    EXPECT_EQ(left, 660.0F);
    EXPECT_EQ(right, 1250.0F);
    constexpr float share = 1e-3F;  // barrel: the extreme point may be between two nodes
    EXPECT_NEAR(u_low, 0.0F, share);
    EXPECT_NEAR(u_high, 1.0F, share);
    EXPECT_NEAR(v_low, 0.0F, share);
    EXPECT_NEAR(v_high, 1.0F, share);
  }
}

TEST(Eye, UnusableEyes)
{
  const auto refused = [](const Eye& eye) -> std::string {
    const std::optional<InputError::Facts> facts = usability_error(eye, "bench.toml", "left");
    return facts ? InputError(*facts).what() : "";
  };
  EXPECT_EQ(refused(sample_eye()), "");
  Eye eye = sample_eye(-0.5, 0.0);
  EXPECT_NE(refused(eye).find("left.distortion"), std::string::npos) << refused(eye);
  // Needs an image of 4.2 times the visible part's size.
  eye = sample_eye(1.0, 1.0);
  EXPECT_NE(refused(eye).find("left.distortion"), std::string::npos) << refused(eye);
  EXPECT_NE(refused(eye).find("at most 2360.000000 x 1760.000000"), std::string::npos) << refused(eye);
  eye = sample_eye(0.01, 0.0);
  eye.distortion.centre_px = {20000.0, 780.0};
  EXPECT_NE(refused(eye).find("left.distortion"), std::string::npos) << refused(eye);
  eye = sample_eye();
  eye.visible.width = 700;
  EXPECT_NE(refused(eye).find("left.visible"), std::string::npos);
  eye = sample_eye();
  eye.distance_px = 0.0;
  EXPECT_NE(refused(eye).find("left.distance_px"), std::string::npos);
}

// No window overlaps the other or leaves the frame buffer.
TEST(Layout, EveryLayout)
{
  for (std::size_t k = 0; k < layout_names().size(); ++k) {
    const auto layout = layout_named(layout_names()[k]);
    ASSERT_TRUE(layout.has_value());
    for (const auto& [width, height] : {std::pair{1280, 1024}, {1921, 1081}, {640, 480}}) {
      const EyeWindows windows = eye_windows(*layout, width, height, "bench.toml");
      EXPECT_EQ(within(windows.left, windows.right).width, 0);
      for (const Viewport& v : {windows.left, windows.right}) {
        EXPECT_EQ(within(v, {0, 0, width, height}).width, v.width);
        EXPECT_EQ(within(v, {0, 0, width, height}).height, v.height);
        EXPECT_GT(v.width * v.height, 0);
      }
    }
    EXPECT_THROW(eye_windows(*layout, 1, 1, "bench.toml"), InputError);
  }
}

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

}  // namespace vrda::view::stereo_test
