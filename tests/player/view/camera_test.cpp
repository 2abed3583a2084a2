// Cameras: fitted, turned by the user, turned by a job.
#include <gtest/gtest.h>
#include <random>

#include "core/text.hpp"
#include "core/units.hpp"
#include "support/models.hpp"
#include "view/camera.hpp"
#include "view/player_state.hpp"

namespace vrda::view::camera_test {

constexpr double rounding = 1e-10;  // of image coordinates of order one

/// Normalised device coordinates of a point: x and y on [-1, 1], z in the depth range.
Eigen::Vector3d projected(const Camera& camera, const Eigen::Vector3d& p_world_mm)
{
  const Eigen::Vector3d p_camera = camera.X_world_camera.inverse() * p_world_mm;
  const Eigen::Vector4d clip = projection(camera) * p_camera.homogeneous();
  return clip.hnormalized();
}

Camera fitted(const std::vector<Eigen::Vector3d>& points, const Eigen::Matrix3d& R,
              const FrameOptions& options = {})
{
  CameraFit fit(R, options);
  fit.include(points);
  return fit.camera();
}

std::vector<Eigen::Vector3d> box_corners(const Eigen::Vector3d& low, const Eigen::Vector3d& high)
{
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(8);
  for (int corner = 0; corner < 8; ++corner) {
    corners.emplace_back(corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y(),
                         corner & 4 ? high.z() : low.z());
  }
  return corners;
}

// Every view has the whole box in the filled part and fills it.
TEST(Camera, FitFillsThePicture)
{
  const std::vector<Eigen::Vector3d> corners = box_corners({-30, -70, -45}, {25, 40, 38});
  for (const std::string& name : view_names()) {
    for (const double aspect : {0.6, 4.0 / 3.0, 3.0}) {
      SCOPED_TRACE(name + " " + std::to_string(aspect));
      FrameOptions options;
      options.aspect = aspect;
      options.fill_fraction = 0.8;
      const Camera camera = fitted(corners, view_rotation(*view_named(name), Side::right), options);
      Eigen::Vector2d low(9, 9), high(-9, -9);
      for (const Eigen::Vector3d& corner : corners) {
        low = low.cwiseMin(projected(camera, corner).head<2>());
        high = high.cwiseMax(projected(camera, corner).head<2>());
      }
      EXPECT_GE(low.minCoeff(), -0.8 - rounding);
      EXPECT_LE(high.maxCoeff(), 0.8 + rounding);
      EXPECT_NEAR(low.minCoeff(), -0.8, rounding);
      EXPECT_NEAR(high.maxCoeff(), 0.8, rounding);
      // Both borders of one direction are touched.
      EXPECT_NEAR((high - low).maxCoeff(), 1.6, rounding);
    }
  }
}

TEST(Camera, FitOverPoses)
{
  const std::vector<Eigen::Vector3d> first = box_corners({-1, -2, -3}, {1, 2, 3});
  const std::vector<Eigen::Vector3d> second = box_corners({-5, 0, 0}, {0, 1, 1});
  std::vector<Eigen::Vector3d> both = first;
  both.insert(both.end(), second.begin(), second.end());
  const Eigen::Matrix3d R = view_rotation(View::oblique, Side::left);
  CameraFit fit(R);
  fit.include(first);
  fit.include(second);
  EXPECT_EQ(fit.camera().X_world_camera.matrix(), fitted(both, R).X_world_camera.matrix());
  EXPECT_THROW(CameraFit(R).camera(), InternalError);
}

TEST(Camera, NamedViews)
{
  struct Row {
    View view;
    Side side;
    Eigen::Vector3d towards_viewer, right_of_picture;
  };
  const Eigen::Vector3d x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  for (const Row& row : {Row{View::front, Side::right, x, -z}, Row{View::back, Side::right, -x, z},
                         Row{View::right, Side::left, z, x}, Row{View::left, Side::left, -z, -x},
                         Row{View::lateral, Side::right, z, x}, Row{View::lateral, Side::left, -z, -x},
                         Row{View::medial, Side::right, -z, -x}, Row{View::medial, Side::left, z, x},
                         Row{View::top, Side::right, y, z}}) {
    const Eigen::Matrix3d R = view_rotation(row.view, row.side);
    EXPECT_LT((R.col(2) - row.towards_viewer).norm(), rounding);
    EXPECT_LT((R.col(0) - row.right_of_picture).norm(), rounding);
    EXPECT_NEAR(R.determinant(), 1.0, rounding);
  }
  // The oblique view shows front, lateral side and top of both knees.
  EXPECT_GT(view_rotation(View::oblique, Side::right).col(2).minCoeff(), 0.2);
  EXPECT_LT(view_rotation(View::oblique, Side::left)(2, 2), -0.2);
  // The inverted view shows front, lateral side and underside, and image up is world down.
  const Eigen::Matrix3d inverted = view_rotation(View::inverted, Side::right);
  EXPECT_GT(inverted(0, 2), 0.2);
  EXPECT_LT(inverted(1, 2), -0.2);
  EXPECT_GT(inverted(2, 2), 0.2);
  EXPECT_LT(inverted(1, 1), -0.5);
  EXPECT_GT(view_rotation(View::inverted, Side::left).determinant(), 0.0);
}

TEST(Camera, DepthRange)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  place(scene, frames_of(store::Motion(model, "raw").at({rad_from_deg(50.0), 0.0})));
  const std::vector<Eigen::Vector3d> points = points_within(scene, {});
  const Camera camera = with_depth_range(fitted(points, view_rotation(View::oblique, Side::right)), scene);
  EXPECT_GT(camera.near_mm, 0.0);
  for (const Eigen::Vector3d& p_mm : points) {
    const Eigen::Vector3d p = projected(camera, p_mm);
    EXPECT_LE(std::abs(p.z()), 1.0);
  }
}

// The depth range stays sane with things behind the camera.
TEST(Camera, DepthRangeBehindTheCamera)
{
  store::MotionModel model = test::model_of({});
  test::add_bodies(model);
  const Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  const Camera inside = with_depth_range(Camera{}, scene);  // at the middle of the ball
  EXPECT_GT(inside.near_mm, 0.0);
  EXPECT_GT(inside.far_mm, inside.near_mm);
}

constexpr double rounding_mm = 1e-9;  // of positions about 1000 mm away
constexpr double rounding_px = 1e-8;
constexpr Viewport viewport{40, 20, 800, 600};

OrbitCamera sample_gaze()
{
  OrbitCamera gaze;
  gaze.camera.aspect = static_cast<double>(viewport.width) / viewport.height;
  gaze.camera.half_height_tangent = 0.2;
  gaze.camera.X_world_camera.linear() = view_rotation(View::oblique, Side::right);
  gaze.pivot_world_mm = {3, -4, 5};
  gaze.camera.X_world_camera.translation() =
      gaze.pivot_world_mm + gaze.camera.X_world_camera.linear() * Eigen::Vector3d(20, -30, 400);
  return gaze;
}

/// Pixel of a world point by the OpenGL projection.
Eigen::Vector2d pixel(const Camera& camera, const Eigen::Vector3d& p_world_mm)
{
  const Eigen::Vector3d p = camera.X_world_camera.inverse() * p_world_mm;
  const Eigen::Vector3d ndc = (projection(camera) * p.homogeneous()).hnormalized();
  return {viewport.x + 0.5 * viewport.width * (1.0 + ndc.x()),
          viewport.y + 0.5 * viewport.height * (1.0 - ndc.y())};
}

void expect_same(const OrbitCamera& a, const OrbitCamera& b)
{
  EXPECT_LE((a.camera.X_world_camera.matrix() - b.camera.X_world_camera.matrix()).cwiseAbs().maxCoeff(),
            rounding_mm);
  EXPECT_LE((a.pivot_world_mm - b.pivot_world_mm).norm(), rounding_mm);
}

// A pixel of drag moves what lies at the pivots depth by a pixel.
TEST(Gaze, DragByAPixel)
{
  const OrbitCamera gaze = sample_gaze();
  const OrbitCamera moved = dragged({DragKind::translate, gaze, {300, 200}}, {301, 200}, viewport);
  const OrbitCamera lowered = dragged({DragKind::translate, gaze, {300, 200}}, {300, 201}, viewport);
  const Eigen::Vector3d right = gaze.camera.X_world_camera.linear().col(0);
  const Eigen::Vector3d up = gaze.camera.X_world_camera.linear().col(1);
  for (const Eigen::Vector3d& beside : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(25 * right - 40 * up)}) {
    const Eigen::Vector3d p_world_mm = gaze.pivot_world_mm + beside;
    const Eigen::Vector2d before = pixel(gaze.camera, p_world_mm);
    EXPECT_LE((pixel(moved.camera, p_world_mm) - before - Eigen::Vector2d(1, 0)).norm(), rounding_px);
    EXPECT_LE((pixel(lowered.camera, p_world_mm) - before - Eigen::Vector2d(0, 1)).norm(), rounding_px);
  }
}

TEST(Gaze, DragBack)
{
  for (const DragKind kind : {DragKind::translate, DragKind::rotate, DragKind::depth}) {
    const OrbitCamera gaze = sample_gaze();
    const OrbitCamera back = dragged({kind, gaze, {123, 456}}, {123, 456}, viewport);
    EXPECT_EQ(back.camera.X_world_camera.matrix(), gaze.camera.X_world_camera.matrix());
  }
}

TEST(Gaze, TurnInParts)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0, 900), y(0, 700);
  int n_inside = 0, n_outside = 0;
  for (int round = 0; round < 200; ++round) {
    const Eigen::Vector2d a(x(random), y(random)), b(x(random), y(random)), c(x(random), y(random));
    (((b - pixel(sample_gaze().camera, sample_gaze().pivot_world_mm)).norm() < 190) ? n_inside : n_outside)++;
    const OrbitCamera first = dragged({DragKind::rotate, sample_gaze(), a}, b, viewport);
    const OrbitCamera parts = dragged({DragKind::rotate, first, b}, c, viewport);
    expect_same(parts, dragged({DragKind::rotate, sample_gaze(), a}, c, viewport));
    expect_same(dragged({DragKind::rotate, parts, c}, a, viewport), sample_gaze());
  }
  EXPECT_GE(n_inside, 20);
  EXPECT_GE(n_outside, 20);
}

// Turns by twice the arc about the pivot which stays.
TEST(Gaze, TurnByTwiceTheArc)
{
  OrbitCamera gaze = sample_gaze();
  gaze = centred_on(gaze, gaze.pivot_world_mm);
  const Eigen::Vector2d middle(viewport.x + 400, viewport.y + 300);
  // Half the ball's radius (0.45 of 600 px) to the right of the middle: an arc of 30 degrees.
  const OrbitCamera turned =
      dragged({DragKind::rotate, gaze, middle}, middle + Eigen::Vector2d(135, 0), viewport);
  EXPECT_LE((pixel(turned.camera, turned.pivot_world_mm) - middle).norm(), rounding_px);
  EXPECT_NEAR(depth_mm(turned), depth_mm(gaze), rounding_mm);
  const Eigen::Matrix3d R_camera = gaze.camera.X_world_camera.linear(),
                        R_turned = turned.camera.X_world_camera.linear();
  // The near side of the object moves right: a rotation about the screen's up axis by 60 degrees.
  const Eigen::Matrix3d R_object = R_turned.transpose() * R_camera;
  const SinCos sixty = sin_cos(rad_from_deg(60.0));
  Eigen::Matrix3d expected;
  expected << sixty.cos, 0, sixty.sin, 0, 1, 0, -sixty.sin, 0, sixty.cos;
  EXPECT_LE((R_object - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Gaze, ManyTurns)
{
  std::mt19937 random(11);
  std::uniform_real_distribution<double> x(0, 900), y(0, 700);
  OrbitCamera gaze = sample_gaze();
  for (int turn = 0; turn < 20000; ++turn)
    gaze = dragged({DragKind::rotate, gaze, {x(random), y(random)}}, {x(random), y(random)}, viewport);
  const Eigen::Matrix3d R = gaze.camera.X_world_camera.linear();
  EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
  EXPECT_NEAR(depth_mm(gaze), 400.0, 1e-7);  // 20,000 rounding errors of about 1e-13 mm
}

TEST(Gaze, DepthDrag)
{
  const OrbitCamera gaze = sample_gaze();
  // A quarter of the height upward: (1 + 1/4) / (1 - 1/4) times as far.
  const OrbitCamera away = dragged({DragKind::depth, gaze, {300, 400}}, {310, 250}, viewport);
  EXPECT_NEAR(depth_mm(away), 400.0 * 5.0 / 3.0, rounding_mm);
  const OrbitCamera near = dragged({DragKind::depth, gaze, {300, 250}}, {290, 400}, viewport);
  EXPECT_NEAR(depth_mm(near), 400.0 * 3.0 / 5.0, rounding_mm);
  const Eigen::Vector3d way =
      away.camera.X_world_camera.translation() - gaze.camera.X_world_camera.translation();
  EXPECT_NEAR(way.normalized().dot(gaze.camera.X_world_camera.linear().col(2)), 1.0, 1e-12);
}

TEST(Gaze, Wheel)
{
  const OrbitCamera gaze = sample_gaze();
  EXPECT_NEAR(depth_mm(moved_closer(gaze, 2.0)), 400.0 * 0.81, rounding_mm);
  expect_same(moved_closer(moved_closer(gaze, 3.0), -3.0), gaze);
  EXPECT_NEAR(depth_mm(moved_closer(gaze, 0.5)), 400.0 * 0.95, rounding_mm);
}

// Neither wheel nor drag leads through the pivot or out of sight.
TEST(Gaze, DepthLimits)
{
  EXPECT_NEAR(depth_mm(moved_closer(sample_gaze(), 1000.0)), 10.0, rounding_mm);
  EXPECT_NEAR(depth_mm(moved_closer(sample_gaze(), -1000.0)), 20000.0, 1e-7);
  OrbitCamera gaze = sample_gaze();
  for (int i = 0; i < 20; ++i) gaze = dragged({DragKind::depth, gaze, {0, 0}}, {0, 5000}, viewport);
  EXPECT_NEAR(depth_mm(gaze), 10.0, rounding_mm);
}

/// A triangle normal to the line of sight, 300 mm in front of the camera; its mesh has its own frame.
Scene one_triangle(const Pose& X_world_mesh)
{
  Scene scene;
  Drawable& drawable = scene.drawables.emplace_back();
  drawable.X_world_mesh = X_world_mesh;
  drawable.mesh.vertices = {{{-50, -50, 0}, {0, 0, 1}}, {{50, -50, 0}, {0, 0, 1}}, {{0, 80, 0}, {0, 0, 1}}};
  drawable.mesh.triangles = {0, 1, 2};
  return scene;
}

TEST(Gaze, PointUnderPointer)
{
  const OrbitCamera gaze = sample_gaze();
  const Pose X_world_mesh = gaze.camera.X_world_camera * Eigen::Translation3d(10, 5, -300);
  const Scene scene = one_triangle(X_world_mesh);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(440, 320), Eigen::Vector2d(470, 250)}) {
    const std::optional<Eigen::Vector3d> found = point_under(scene, gaze.camera, viewport, p);
    ASSERT_TRUE(found.has_value());
    EXPECT_LE((pixel(gaze.camera, *found) - p).norm(), rounding_px);
    EXPECT_NEAR((gaze.camera.X_world_camera.inverse() * *found).z(), -300.0, rounding_mm);
    const OrbitCamera centred = centred_on(gaze, *found);
    EXPECT_LE((pixel(centred.camera, *found) - Eigen::Vector2d(440, 320)).norm(), rounding_px);
    EXPECT_NEAR(depth_mm(centred), 300.0, rounding_mm);
    EXPECT_EQ(centred.camera.X_world_camera.linear(), gaze.camera.X_world_camera.linear());
  }
  EXPECT_FALSE(point_under(scene, gaze.camera, viewport, {41, 21}).has_value());
}

// The pivot is inside the bone: the wheel and a drag in depth end 10 mm before its surface, and lead back.
TEST(Gaze, ZoomStopsAtTheSurface)
{
  const OrbitCamera start = sample_gaze();
  const Pose X_world_mesh = start.camera.X_world_camera * Eigen::Translation3d(0, 0, -300);
  const Scene scene = one_triangle(X_world_mesh);
  const auto to_surface_mm = [&](const OrbitCamera& gaze) {
    return -(gaze.camera.X_world_camera.inverse() * X_world_mesh.translation()).z();
  };
  const auto event = [](InputKind kind, double y_px, double notches) {
    InputEvent made;
    made.kind = kind;
    made.button = MouseButton::middle;
    made.x_px = 440;
    made.y_px = y_px;
    made.wheel = notches;
    return made;
  };
  Navigation navigation;
  OrbitCamera gaze = start;
  for (int i = 0; i < 40; ++i)
    gaze = navigation.after(event(InputKind::wheel, 320, 1.0), gaze, scene, viewport);
  EXPECT_NEAR(to_surface_mm(gaze), 10.0, rounding_mm);
  EXPECT_GT(to_surface_mm(navigation.after(event(InputKind::wheel, 320, -1.0), gaze, scene, viewport)), 20.0);
  gaze = navigation.after(event(InputKind::press, 320, 0.0), start, scene, viewport);
  for (int y_px = 320; y_px < 2600; y_px += 100)
    gaze = navigation.after(event(InputKind::motion, y_px, 0.0), gaze, scene, viewport);
  EXPECT_NEAR(to_surface_mm(gaze), 10.0, rounding_mm);
  gaze = navigation.after(event(InputKind::motion, 320, 0.0), gaze, scene, viewport);
  expect_same(gaze, start);
}

// What is hidden behind the camera or a layer is not under the pointer.
TEST(Gaze, NothingUnderPointer)
{
  const OrbitCamera gaze = sample_gaze();
  const Pose before = gaze.camera.X_world_camera * Eigen::Translation3d(0, 0, -300);
  const Pose behind = gaze.camera.X_world_camera * Eigen::Translation3d(0, 0, 300);
  EXPECT_FALSE(point_under(one_triangle(behind), gaze.camera, viewport, {440, 320}).has_value());
  Scene hidden = one_triangle(before);
  hidden.drawables[0].is_shown = false;
  EXPECT_FALSE(point_under(hidden, gaze.camera, viewport, {440, 320}).has_value());
  Scene layer = one_triangle(before);
  layer.drawables[0].layer = Layer::axes;
  EXPECT_FALSE(point_under(layer, gaze.camera, viewport, {440, 320}).has_value());
}

// A turned view is that of a turned and shifted joint.
TEST(Camera, TurnedView)
{
  const std::vector<Eigen::Vector3d> corners{{-30, 0, 0}, {30, 0, 0}, {0, 30, 0},
                                             {0, -30, 0}, {0, 0, 30}, {0, 0, -30}};
  const Eigen::Vector3d turn_rad(rad_from_deg(20.0), rad_from_deg(-50.0), rad_from_deg(70.0)),
      shift_mm(3.0, -4.0, 5.0);
  const auto seen = [&](const CameraView& view, const Eigen::Vector3d& p_world_mm) -> Eigen::Vector3d {
    CameraFit fit(view.R_world_camera);
    fit.include(corners);
    return placed_camera(fit, view, 1.0).X_world_camera.inverse() * p_world_mm;
  };
  const CameraView shifted = turned_view("turned", turn_rad, shift_mm, Side::right);
  const CameraView turned = turned_view("turned", turn_rad, Eigen::Vector3d::Zero(), Side::right);
  // In the axes of the front view: X to the subject's left, Y up, Z forward.
  const Eigen::Matrix3d R_front = named_view("front", View::front, Side::right).R_world_camera;
  const Eigen::Matrix3d R_turn =
      rotation_z(turn_rad.z()) * rotation_y(turn_rad.y()) * rotation_x(turn_rad.x());
  for (const Eigen::Vector3d& p_mm : corners) {
    const Eigen::Vector3d about_origin = seen(turned, p_mm) - seen(turned, Eigen::Vector3d::Zero());
    EXPECT_LT((about_origin - R_turn * (R_front.transpose() * p_mm)).norm(), rounding);
    EXPECT_LT((seen(shifted, p_mm) - seen(turned, p_mm) - shift_mm).norm(), rounding);
  }
}

}  // namespace vrda::view::camera_test
