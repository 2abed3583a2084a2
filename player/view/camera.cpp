#include "view/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "view/gl_mesh.hpp"

namespace vrda::view {
namespace {

/// Smallest ratio of near to far plane: 24 bits of depth then resolve 0.01 mm at one metre.
constexpr double least_near_by_far = 0.01;

/// Camera axes for a viewer in direction `from`.
Eigen::Matrix3d looking(const Eigen::Vector3d& from, const Eigen::Vector3d& up)
{
  Eigen::Matrix3d R;
  R.col(2) = from.normalized();
  R.col(0) = up.cross(R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

}  // namespace

const std::vector<std::string>& view_names()
{
  static const std::vector<std::string> names{"front",   "back", "left",    "right",   "medial",
                                              "lateral", "top",  "oblique", "inverted"};
  return names;
}

std::optional<View> view_named(const std::string& name)
{
  // The usual side view of a knee is the lateral one.
  const std::string own_name = name == "side" ? "lateral" : name;
  const auto found = std::ranges::find(view_names(), own_name);
  if (found == view_names().end()) return std::nullopt;
  return static_cast<View>(found - view_names().begin());
}

Eigen::Matrix3d view_rotation(View view, Side side)
{
  const Eigen::Vector3d anterior = Eigen::Vector3d::UnitX(), proximal = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d lateral = side == Side::right ? right : Eigen::Vector3d(-right);
  const Eigen::Vector3d aside = anterior + 0.75 * lateral;
  // From the joint to the camera, and up; in the order of View.
  const std::array<std::array<Eigen::Vector3d, 2>, 9> views{{{anterior, proximal},
                                                             {-anterior, proximal},
                                                             {-right, proximal},
                                                             {right, proximal},
                                                             {-lateral, proximal},
                                                             {lateral, proximal},
                                                             {proximal, anterior},
                                                             {aside + 0.45 * proximal, proximal},
                                                             {aside - 0.75 * proximal, -proximal}}};
  const auto& [towards, up] = views.at(static_cast<std::size_t>(view));
  return looking(towards, up);
}

CameraFit::CameraFit(const Eigen::Matrix3d& R_world_camera, const FrameOptions& options)
    : R_world_camera_(R_world_camera), options_(options)
{
  const SinCos half = sin_cos(0.5 * options.vertical_field_of_view_rad);
  half_height_tangent_ = half.sin / half.cos;
}

void CameraFit::include(const std::vector<Eigen::Vector3d>& points_world_mm)
{
  // A point p is inside for a camera at c when |p_x - c_x| <= t (c_z - p_z), hence
  // c_x + t c_z >= p_x + t p_z and c_x - t c_z <= p_x - t p_z; the same for y.
  const auto widen = [](Wedge& wedge, double p, double z, double t) {
    wedge.lowest = std::min(wedge.lowest, p - t * z);
    wedge.highest = std::max(wedge.highest, p + t * z);
  };
  const double t_y = options_.fill_fraction * half_height_tangent_, t_x = t_y * options_.aspect;
  for (const Eigen::Vector3d& p_world_mm : points_world_mm) {
    const Eigen::Vector3d p = R_world_camera_.transpose() * p_world_mm;
    widen(wide_, p.x(), p.z(), t_x);
    widen(tall_, p.y(), p.z(), t_y);
  }
}

Camera CameraFit::camera() const
{
  check(std::isfinite(wide_.highest), "a camera is fitted to at least one point");
  const double t_y = options_.fill_fraction * half_height_tangent_, t_x = t_y * options_.aspect;
  const double c_z =
      std::max((wide_.highest - wide_.lowest) / (2.0 * t_x), (tall_.highest - tall_.lowest) / (2.0 * t_y));
  const Eigen::Vector3d c(0.5 * (wide_.highest + wide_.lowest), 0.5 * (tall_.highest + tall_.lowest), c_z);
  Camera camera;
  camera.half_height_tangent = half_height_tangent_;
  camera.aspect = options_.aspect;
  camera.X_world_camera.linear() = R_world_camera_;
  camera.X_world_camera.translation() = R_world_camera_ * c;
  return camera;
}

Camera with_depth_range(Camera camera, const Scene& scene)
{
  double nearest_mm = std::numeric_limits<double>::infinity(), farthest_mm = 1.0;
  const Pose X_camera_world = camera.X_world_camera.inverse();
  const auto include = [&](const Drawable& drawable) {
    if (!drawable.is_shown) return;
    const Pose X_camera_mesh = X_camera_world * drawable.X_world_mesh;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p_mm =
          drawable.box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
      const double depth_mm = -(X_camera_mesh * p_mm).z();
      nearest_mm = std::min(nearest_mm, depth_mm);
      farthest_mm = std::max(farthest_mm, depth_mm);
    }
  };
  for (const Scene* part = &scene; part != nullptr; part = part->other)
    for (const Drawable& drawable : part->drawables) include(drawable);
  camera.far_mm = 1.01 * farthest_mm;
  camera.near_mm = std::clamp(0.99 * nearest_mm, least_near_by_far * camera.far_mm, 0.9 * camera.far_mm);
  return camera;
}

Eigen::Matrix4d projection(const Camera& camera)
{
  const double n = camera.near_mm, f = camera.far_mm, t = camera.half_height_tangent;
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 1.0 / (t * camera.aspect);
  P(1, 1) = 1.0 / t;
  P(0, 2) = camera.middle_tangent.x() / (t * camera.aspect);
  P(1, 2) = camera.middle_tangent.y() / t;
  P(2, 2) = (f + n) / (n - f);
  P(2, 3) = 2.0 * f * n / (n - f);
  P(3, 2) = -1.0;
  return P;
}

// Pointer navigation.

namespace {

constexpr double ball_fraction = 0.9;      // of the smaller side of the viewport
constexpr double wheel_factor = 0.9;       // of the depth, per notch
constexpr double largest_drag = 0.9;       // of the viewport height; the depth diverges at 1
constexpr double least_depth_mm = 10.0;    // of the pivot and of a surface
constexpr double most_depth_mm = 20000.0;  // a knee covers only a few pixels there

Eigen::Vector3d pivot_camera_mm(const OrbitCamera& gaze)
{
  return gaze.camera.X_world_camera.inverse() * gaze.pivot_world_mm;
}

/// Direction through a pixel in camera axes, with z = -1.
Eigen::Vector3d ray_camera(const Camera& camera, const Viewport& viewport, const Eigen::Vector2d& p_px)
{
  const double right = 2.0 * (p_px.x() - viewport.x) / viewport.width - 1.0;
  const double up = 1.0 - 2.0 * (p_px.y() - viewport.y) / viewport.height;
  const double t = camera.half_height_tangent;
  return {right * t * camera.aspect, up * t, -1.0};
}

Eigen::Vector2d pixel_of(const OrbitCamera& gaze, const Viewport& viewport)
{
  const Eigen::Vector3d p = pivot_camera_mm(gaze);
  const double t = -p.z() * gaze.camera.half_height_tangent;
  return {viewport.x + 0.5 * viewport.width * (1.0 + p.x() / (t * gaze.camera.aspect)),
          viewport.y + 0.5 * viewport.height * (1.0 - p.y() / t)};
}

/// Unit vector to the point of the ball under the pointer, camera axes.
Eigen::Vector3d on_ball(const Eigen::Vector2d& from_middle_px, double radius_px)
{
  const double x = from_middle_px.x() / radius_px, y = -from_middle_px.y() / radius_px;
  const double r_sq = x * x + y * y;
  const double z = r_sq <= 0.5 ? std::sqrt(1.0 - r_sq) : 0.5 / std::sqrt(r_sq);
  return Eigen::Vector3d(x, y, z).normalized();
}

Eigen::Matrix3d half_turn(const Eigen::Vector3d& axis)
{
  return 2.0 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
}

/// Re-orthonormalised, against accumulated rounding.
Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& R)
{
  Eigen::Matrix3d clean;
  clean.col(0) = R.col(0).normalized();
  clean.col(2) = R.col(0).cross(R.col(1)).normalized();
  clean.col(1) = clean.col(2).cross(clean.col(0));
  return clean;
}

OrbitCamera translated(const OrbitCamera& gaze, const Eigen::Vector2d& moved_px, const Viewport& viewport)
{
  const double scale_mm = mm_per_pixel(gaze.camera, viewport, depth_mm(gaze));
  OrbitCamera next = gaze;
  const Eigen::Vector3d moved_camera_mm(moved_px.x() * scale_mm, -moved_px.y() * scale_mm, 0.0);
  next.camera.X_world_camera.translation() -= gaze.camera.X_world_camera.linear() * moved_camera_mm;
  return next;
}

OrbitCamera rotated(const Drag& drag, const Eigen::Vector2d& pointer_px, const Viewport& viewport)
{
  const OrbitCamera& gaze = drag.at_press;
  const Eigen::Vector2d middle_px = pixel_of(gaze, viewport);
  const double radius_px = 0.5 * ball_fraction * std::min(viewport.width, viewport.height);
  // The product of two half turns is a rotation by twice the angle between their axes.
  const Eigen::Matrix3d R_object = half_turn(on_ball(pointer_px - middle_px, radius_px)) *
                                   half_turn(on_ball(drag.press_px - middle_px, radius_px));
  const Eigen::Matrix3d R_world_camera = gaze.camera.X_world_camera.linear();
  OrbitCamera next = gaze;
  next.camera.X_world_camera.linear() = orthonormal(R_world_camera * R_object.transpose());
  next.camera.X_world_camera.translation() =
      gaze.pivot_world_mm - next.camera.X_world_camera.linear() * pivot_camera_mm(gaze);
  return next;
}

OrbitCamera at_depth(const OrbitCamera& gaze, double wanted_mm)
{
  const double now_mm = depth_mm(gaze);
  OrbitCamera next = gaze;
  next.camera.X_world_camera.translation() +=
      (std::clamp(wanted_mm, least_depth_mm, most_depth_mm) - now_mm) *
      gaze.camera.X_world_camera.linear().col(2);
  return next;
}

}  // namespace

double depth_mm(const OrbitCamera& gaze)
{
  return -pivot_camera_mm(gaze).z();
}

double mm_per_pixel(const Camera& camera, const Viewport& viewport, double depth_mm)
{
  return 2.0 * camera.half_height_tangent * depth_mm / viewport.height;
}

OrbitCamera dragged(const Drag& drag, const Eigen::Vector2d& pointer_px, const Viewport& viewport)
{
  const Eigen::Vector2d moved_px = pointer_px - drag.press_px;
  if (moved_px.isZero(0.0)) return drag.at_press;
  switch (drag.kind) {
    case DragKind::translate:
      return translated(drag.at_press, moved_px, viewport);
    case DragKind::rotate:
      return rotated(drag, pointer_px, viewport);
    case DragKind::depth: {
      const double s = std::clamp(-moved_px.y() / viewport.height, -largest_drag, largest_drag);
      return at_depth(drag.at_press, depth_mm(drag.at_press) * (1.0 + s) / (1.0 - s));
    }
  }
  return drag.at_press;
}

OrbitCamera moved_closer(const OrbitCamera& gaze, double notches)
{
  double factor = 1.0, left = std::abs(notches);
  const double whole = notches > 0.0 ? wheel_factor : 1.0 / wheel_factor;
  // Touchpads send fractions of a notch: interpolate linearly between whole ones.
  for (; left >= 1.0; left -= 1.0) factor *= whole;
  factor *= 1.0 + left * (whole - 1.0);
  return at_depth(gaze, depth_mm(gaze) * factor);
}

OrbitCamera centred_on(const OrbitCamera& gaze, const Eigen::Vector3d& point_world_mm)
{
  OrbitCamera next = gaze;
  next.pivot_world_mm = point_world_mm;
  const Eigen::Vector3d from_camera = pivot_camera_mm(next);
  next.camera.X_world_camera.translation() +=
      gaze.camera.X_world_camera.linear() * Eigen::Vector3d(from_camera.x(), from_camera.y(), 0.0);
  return at_depth(next, depth_mm(next));
}

std::optional<Eigen::Vector3d> point_under(const Scene& scene, const Camera& camera, const Viewport& viewport,
                                           const Eigen::Vector2d& pointer_px)
{
  const Eigen::Vector3d from = camera.X_world_camera.translation();
  const Eigen::Vector3d direction = camera.X_world_camera.linear() * ray_camera(camera, viewport, pointer_px);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Drawable& drawable : scene.drawables) {
    if (drawable.layer != Layer::bodies || !drawable.is_shown) continue;
    const Pose X_mesh_world = drawable.X_world_mesh.inverse();
    nearest =
        std::min(nearest, nearest_hit(drawable.mesh, X_mesh_world * from, X_mesh_world.linear() * direction));
  }
  if (!std::isfinite(nearest)) return std::nullopt;
  return from + nearest * direction;
}

namespace {

/// Without reach.
std::optional<Pick> picked_at(const Scene& scene, const Camera& camera, const Viewport& viewport,
                              const Eigen::Vector2d& pointer_px)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d eye = camera.X_world_camera.translation();
  const Eigen::Vector3d direction = camera.X_world_camera.linear() * ray_camera(camera, viewport, pointer_px);
  // From the section on.
  Eigen::Vector3d from = eye;
  if (scene.section) {
    const double towards = scene.section->normal.dot(direction);
    const double along = (scene.section->at_mm - scene.section->normal.dot(eye)) / towards;
    if (!(along > 0.0) || !std::isfinite(along)) return std::nullopt;
    from += along * (1.0 - 1e-9) * direction;
  }
  double nearest = infinity, nearest_solid = infinity;
  std::size_t own = 0, solid = 0;
  for (std::size_t k = 0; k < scene.drawables.size(); ++k) {
    const Drawable& drawable = scene.drawables[k];
    if (drawable.structure.empty() || !drawable.is_shown) continue;
    const Pose X_mesh_world = drawable.X_world_mesh.inverse();
    const double at = nearest_hit(drawable.mesh, X_mesh_world * from, X_mesh_world.linear() * direction);
    if (at < nearest) {
      nearest = at;
      own = k;
    }
    if (at < nearest_solid && drawable.material.opacity >= 0.5F) {
      nearest_solid = at;
      solid = k;
    }
  }
  if (nearest == infinity) return std::nullopt;
  const bool has_solid = nearest_solid < infinity;
  return Pick{has_solid ? solid : own, from + (has_solid ? nearest_solid : nearest) * direction};
}

bool is_thin(const Scene& scene, const std::optional<Pick>& pick)
{
  return pick && scene.drawables[pick->drawable].layer == Layer::ligaments;
}

}  // namespace

std::optional<Pick> picked(const Scene& scene, const Camera& camera, const Viewport& viewport,
                           const Eigen::Vector2d& pointer_px, double reach_px)
{
  const std::optional<Pick> found = picked_at(scene, camera, viewport, pointer_px);
  if (is_thin(scene, found)) return found;
  for (const Eigen::Vector2d& aside : {Eigen::Vector2d(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
    const std::optional<Pick> near = picked_at(scene, camera, viewport, pointer_px + reach_px * aside);
    if (is_thin(scene, near)) return near;
  }
  return found;
}

OrbitCamera before_surface(const OrbitCamera& gaze, OrbitCamera next, const Scene& scene)
{
  const double ahead_mm = depth_mm(gaze) - depth_mm(next);
  if (ahead_mm <= 0.0) return next;
  double seen_mm = std::numeric_limits<double>::infinity();
  const Viewport whole{-1, -1, 2, 2};
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(0, 0), {-0.5, -0.5}, {-0.5, 0.5}, {0.5, -0.5}, {0.5, 0.5}}) {
    if (const auto point = point_under(scene, gaze.camera, whole, p))
      seen_mm = std::min(seen_mm, -(gaze.camera.X_world_camera.inverse() * *point).z());
  }
  const double clear_mm =
      std::max(least_depth_mm, 1.1 * least_near_by_far * with_depth_range(next.camera, scene).far_mm);
  const double back_mm = ahead_mm - std::clamp(seen_mm - clear_mm, 0.0, ahead_mm);
  next.camera.X_world_camera.translation() += back_mm * next.camera.X_world_camera.linear().col(2);
  return next;
}

DragKind drag_of(MouseButton button, bool has_shift, bool has_control)
{
  switch (button) {
    case MouseButton::left:
      return has_shift || has_control ? DragKind::translate : DragKind::rotate;
    case MouseButton::middle:
      return DragKind::depth;
    case MouseButton::right:
      return DragKind::translate;
  }
  return DragKind::rotate;
}

OrbitCamera Navigation::after(const InputEvent& event, const OrbitCamera& gaze, const Scene& scene,
                              const Viewport& viewport)
{
  const Eigen::Vector2d pointer_px(event.x_px, event.y_px);
  switch (event.kind) {
    case InputKind::press: {
      OrbitCamera next = gaze;
      if (event.n_clicks == 2 && event.button == MouseButton::left) {
        if (const auto point = point_under(scene, gaze.camera, viewport, pointer_px)) {
          stop();
          next = centred_on(gaze, *point);
        }
      }
      if (drag_) return next;
      drag_ = Drag{drag_of(event.button, event.has_shift, event.has_control), next, pointer_px};
      button_ = event.button;
      return next;
    }
    case InputKind::motion: {
      if (!drag_) return gaze;
      const OrbitCamera next = dragged(*drag_, pointer_px, viewport);
      return drag_->kind == DragKind::depth ? before_surface(gaze, next, scene) : next;
    }
    case InputKind::release:
      if (event.button == button_) stop();
      return gaze;
    case InputKind::focus_lost:  // a release outside the window is not delivered
      stop();
      return gaze;
    case InputKind::wheel:
      stop();
      return before_surface(gaze, moved_closer(gaze, event.wheel), scene);
    default:
      return gaze;
  }
}

}  // namespace vrda::view
