#include "view/orbit_camera.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/units.hpp"

namespace vrda::gaze_test {

constexpr double rounding_mm = 1e-9;  // of positions about 1000 mm away
constexpr double rounding_px = 1e-8;
constexpr view::Viewport viewport{40, 20, 800, 600};

view::OrbitCamera sample_gaze()
{
  view::OrbitCamera gaze;
  gaze.camera.aspect = static_cast<double>(viewport.width) / viewport.height;
  gaze.camera.half_height_tangent = 0.2;
  gaze.camera.X_world_camera.linear() = view::view_rotation(view::View::oblique, Side::right);
  gaze.pivot_world_mm = {3, -4, 5};
  gaze.camera.X_world_camera.translation() =
      gaze.pivot_world_mm + gaze.camera.X_world_camera.linear() * Eigen::Vector3d(20, -30, 400);
  return gaze;
}

/// Pixel of a world point by the OpenGL projection.
Eigen::Vector2d pixel(const view::Camera& camera, const Eigen::Vector3d& p_world_mm)
{
  const Eigen::Vector3d p = camera.X_world_camera.inverse() * p_world_mm;
  const Eigen::Vector3d ndc = (view::projection(camera) * p.homogeneous()).hnormalized();
  return {viewport.x + 0.5 * viewport.width * (1.0 + ndc.x()),
          viewport.y + 0.5 * viewport.height * (1.0 - ndc.y())};
}

void expect_same(const view::OrbitCamera& a, const view::OrbitCamera& b)
{
  EXPECT_LE((a.camera.X_world_camera.matrix() - b.camera.X_world_camera.matrix()).cwiseAbs().maxCoeff(),
            rounding_mm);
  EXPECT_LE((a.pivot_world_mm - b.pivot_world_mm).norm(), rounding_mm);
}

TEST(Gaze, APixelOfDragMovesWhatLiesAtThePivotsDepthByAPixel)
{
  const view::OrbitCamera gaze = sample_gaze();
  const view::OrbitCamera moved =
      view::dragged({view::DragKind::translate, gaze, {300, 200}}, {301, 200}, viewport);
  const view::OrbitCamera lowered =
      view::dragged({view::DragKind::translate, gaze, {300, 200}}, {300, 201}, viewport);
  const Eigen::Vector3d right = gaze.camera.X_world_camera.linear().col(0);
  const Eigen::Vector3d up = gaze.camera.X_world_camera.linear().col(1);
  for (const Eigen::Vector3d& beside : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(25 * right - 40 * up)}) {
    const Eigen::Vector3d p_world_mm = gaze.pivot_world_mm + beside;
    const Eigen::Vector2d before = pixel(gaze.camera, p_world_mm);
    EXPECT_LE((pixel(moved.camera, p_world_mm) - before - Eigen::Vector2d(1, 0)).norm(), rounding_px);
    EXPECT_LE((pixel(lowered.camera, p_world_mm) - before - Eigen::Vector2d(0, 1)).norm(), rounding_px);
  }
}

TEST(Gaze, ADragBackToItsPressIsBitForBitNothing)
{
  for (const view::DragKind kind :
       {view::DragKind::translate, view::DragKind::rotate, view::DragKind::depth}) {
    const view::OrbitCamera gaze = sample_gaze();
    const view::OrbitCamera back = view::dragged({kind, gaze, {123, 456}}, {123, 456}, viewport);
    EXPECT_EQ(back.camera.X_world_camera.matrix(), gaze.camera.X_world_camera.matrix());
  }
}

TEST(Gaze, TurnsTakenInPartsAreTheTurnAtOnce)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0, 900), y(0, 700);
  int n_inside = 0, n_outside = 0;
  for (int round = 0; round < 200; ++round) {
    const Eigen::Vector2d a(x(random), y(random)), b(x(random), y(random)), c(x(random), y(random));
    (((b - pixel(sample_gaze().camera, sample_gaze().pivot_world_mm)).norm() < 190) ? n_inside : n_outside)++;
    const view::OrbitCamera first = view::dragged({view::DragKind::rotate, sample_gaze(), a}, b, viewport);
    const view::OrbitCamera parts = view::dragged({view::DragKind::rotate, first, b}, c, viewport);
    expect_same(parts, view::dragged({view::DragKind::rotate, sample_gaze(), a}, c, viewport));
    expect_same(view::dragged({view::DragKind::rotate, parts, c}, a, viewport), sample_gaze());
  }
  EXPECT_GE(n_inside, 20);
  EXPECT_GE(n_outside, 20);
}

TEST(Gaze, TurnsByTwiceTheArcAboutThePivotWhichStays)
{
  view::OrbitCamera gaze = sample_gaze();
  gaze = view::centred_on(gaze, gaze.pivot_world_mm);
  const Eigen::Vector2d middle(viewport.x + 400, viewport.y + 300);
  // Half the ball's radius (0.45 of 600 px) to the right of the middle: an arc of 30 degrees.
  const view::OrbitCamera turned =
      view::dragged({view::DragKind::rotate, gaze, middle}, middle + Eigen::Vector2d(135, 0), viewport);
  EXPECT_LE((pixel(turned.camera, turned.pivot_world_mm) - middle).norm(), rounding_px);
  EXPECT_NEAR(view::depth_mm(turned), view::depth_mm(gaze), rounding_mm);
  const Eigen::Matrix3d R_camera = gaze.camera.X_world_camera.linear(),
                        R_turned = turned.camera.X_world_camera.linear();
  // The near side of the object moves right: a rotation about the screen's up axis by 60 degrees.
  const Eigen::Matrix3d R_object = R_turned.transpose() * R_camera;
  const SinCos sixty = sin_cos(rad_from_deg(60.0));
  Eigen::Matrix3d expected;
  expected << sixty.cos, 0, sixty.sin, 0, 1, 0, -sixty.sin, 0, sixty.cos;
  EXPECT_LE((R_object - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Gaze, ManyTurnsLeaveARotation)
{
  std::mt19937 random(11);
  std::uniform_real_distribution<double> x(0, 900), y(0, 700);
  view::OrbitCamera gaze = sample_gaze();
  for (int turn = 0; turn < 20000; ++turn)
    gaze = view::dragged({view::DragKind::rotate, gaze, {x(random), y(random)}}, {x(random), y(random)},
                         viewport);
  const Eigen::Matrix3d R = gaze.camera.X_world_camera.linear();
  EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
  EXPECT_NEAR(view::depth_mm(gaze), 400.0, 1e-7);  // 20,000 rounding errors of about 1e-13 mm
}

TEST(Gaze, DepthGoesAlongTheLineOfSight)
{
  const view::OrbitCamera gaze = sample_gaze();
  // A quarter of the height upward: (1 + 1/4) / (1 - 1/4) times as far.
  const view::OrbitCamera away =
      view::dragged({view::DragKind::depth, gaze, {300, 400}}, {310, 250}, viewport);
  EXPECT_NEAR(view::depth_mm(away), 400.0 * 5.0 / 3.0, rounding_mm);
  const view::OrbitCamera near =
      view::dragged({view::DragKind::depth, gaze, {300, 250}}, {290, 400}, viewport);
  EXPECT_NEAR(view::depth_mm(near), 400.0 * 3.0 / 5.0, rounding_mm);
  const Eigen::Vector3d way =
      away.camera.X_world_camera.translation() - gaze.camera.X_world_camera.translation();
  EXPECT_NEAR(way.normalized().dot(gaze.camera.X_world_camera.linear().col(2)), 1.0, 1e-12);
}

TEST(Gaze, WheelNotchesMultiplyAndUndoEachOther)
{
  const view::OrbitCamera gaze = sample_gaze();
  EXPECT_NEAR(view::depth_mm(view::moved_closer(gaze, 2.0)), 400.0 * 0.81, rounding_mm);
  expect_same(view::moved_closer(view::moved_closer(gaze, 3.0), -3.0), gaze);
  EXPECT_NEAR(view::depth_mm(view::moved_closer(gaze, 0.5)), 400.0 * 0.95, rounding_mm);
}

TEST(Gaze, NeitherWheelNorDragLeadsThroughThePivotOrOutOfSight)
{
  EXPECT_NEAR(view::depth_mm(view::moved_closer(sample_gaze(), 1000.0)), 10.0, rounding_mm);
  EXPECT_NEAR(view::depth_mm(view::moved_closer(sample_gaze(), -1000.0)), 20000.0, 1e-7);
  view::OrbitCamera gaze = sample_gaze();
  for (int i = 0; i < 20; ++i)
    gaze = view::dragged({view::DragKind::depth, gaze, {0, 0}}, {0, 5000}, viewport);
  EXPECT_NEAR(view::depth_mm(gaze), 10.0, rounding_mm);
}

/// A triangle normal to the line of sight, 300 mm in front of the camera; its mesh has its own frame.
view::Scene one_triangle(const Pose& X_world_mesh)
{
  view::Scene scene;
  view::Drawable& drawable = scene.drawables.emplace_back();
  drawable.X_world_mesh = X_world_mesh;
  drawable.mesh.vertices = {{{-50, -50, 0}, {0, 0, 1}}, {{50, -50, 0}, {0, 0, 1}}, {{0, 80, 0}, {0, 0, 1}}};
  drawable.mesh.triangles = {0, 1, 2};
  return scene;
}

TEST(Gaze, APointUnderThePointerIsDrawnUnderIt)
{
  const view::OrbitCamera gaze = sample_gaze();
  const Pose X_world_mesh = gaze.camera.X_world_camera * Eigen::Translation3d(10, 5, -300);
  const view::Scene scene = one_triangle(X_world_mesh);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(440, 320), Eigen::Vector2d(470, 250)}) {
    const std::optional<Eigen::Vector3d> found = view::point_under(scene, gaze.camera, viewport, p);
    ASSERT_TRUE(found.has_value());
    EXPECT_LE((pixel(gaze.camera, *found) - p).norm(), rounding_px);
    EXPECT_NEAR((gaze.camera.X_world_camera.inverse() * *found).z(), -300.0, rounding_mm);
    const view::OrbitCamera centred = view::centred_on(gaze, *found);
    EXPECT_LE((pixel(centred.camera, *found) - Eigen::Vector2d(440, 320)).norm(), rounding_px);
    EXPECT_NEAR(view::depth_mm(centred), 300.0, rounding_mm);
    EXPECT_EQ(centred.camera.X_world_camera.linear(), gaze.camera.X_world_camera.linear());
  }
  EXPECT_FALSE(view::point_under(scene, gaze.camera, viewport, {41, 21}).has_value());
}

TEST(Gaze, WhatIsHiddenBehindTheCameraOrALayerIsNotUnderThePointer)
{
  const view::OrbitCamera gaze = sample_gaze();
  const Pose before = gaze.camera.X_world_camera * Eigen::Translation3d(0, 0, -300);
  const Pose behind = gaze.camera.X_world_camera * Eigen::Translation3d(0, 0, 300);
  EXPECT_FALSE(view::point_under(one_triangle(behind), gaze.camera, viewport, {440, 320}).has_value());
  view::Scene hidden = one_triangle(before);
  hidden.drawables[0].is_shown = false;
  EXPECT_FALSE(view::point_under(hidden, gaze.camera, viewport, {440, 320}).has_value());
  view::Scene layer = one_triangle(before);
  layer.drawables[0].layer = view::Layer::axes;
  EXPECT_FALSE(view::point_under(layer, gaze.camera, viewport, {440, 320}).has_value());
}

}  // namespace vrda::gaze_test
