#include "view/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"

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
  for (const Drawable& drawable : scene.drawables) {
    if (!drawable.is_shown) continue;
    const Pose X_camera_mesh = X_camera_world * drawable.X_world_mesh;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p_mm =
          drawable.box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
      const double depth_mm = -(X_camera_mesh * p_mm).z();
      nearest_mm = std::min(nearest_mm, depth_mm);
      farthest_mm = std::max(farthest_mm, depth_mm);
    }
  }
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

}  // namespace vrda::view
