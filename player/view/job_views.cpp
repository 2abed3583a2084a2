#include "view/job_views.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/units.hpp"
#include "core/document.hpp"

namespace vrda::view {

CameraView named_view(const std::string& name, view::View view, Side side)
{
  return {name, view::view_rotation(view, side), Eigen::Vector3d::Zero()};
}

CameraView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad,
                       const Eigen::Vector3d& shift_mm, Side side)
{
  const Eigen::Matrix3d R_turn =
      rotation_z(turn_rad.z()) * rotation_y(turn_rad.y()) * rotation_x(turn_rad.x());
  // Rotating the joint equals the inverse rotation of the camera.
  return {name, view::view_rotation(view::View::front, side) * R_turn.transpose(), shift_mm};
}

view::Camera placed_camera(const view::CameraFit& fit, const CameraView& view, double zoom)
{
  view::Camera camera = fit.camera();
  camera.half_height_tangent /= zoom;
  camera.X_world_camera.translation() -= view.R_world_camera * view.shift_camera_mm;
  return camera;
}

std::vector<CameraView> camera_views(const JobViews& job, Side side)
{
  std::vector<CameraView> views;
  for (const JobView& view : job.views) {
    views.push_back(turned_view("view " + std::to_string(view.number),
                                view.orientation_deg * rad_from_deg(1.0), view.shift_mm, side));
  }
  return views;
}

bool has_usable_size(const JobViews& job)
{
  return std::min(job.width_px, job.height_px) >= 16 && std::max(job.width_px, job.height_px) <= 4096;
}

namespace {

/// The number or the list of n numbers of a key; all zero if it has another form.
template <int n>
Eigen::Matrix<double, n, 1> numbers_in(const core::DocumentValue& table, std::string_view key)
{
  using List = core::DocumentValue::List;
  const core::DocumentValue* const value = table.find(key);
  const List list = value == nullptr ? List{} : value->list() == nullptr ? List{*value} : *value->list();
  Eigen::Matrix<double, n, 1> numbers = Eigen::Matrix<double, n, 1>::Zero();
  if (list.size() != n || !std::ranges::all_of(list, &core::DocumentValue::is_number)) return numbers;
  for (Eigen::Index i = 0; i < n; ++i)
    numbers[i] = core::number_at(list[static_cast<std::size_t>(i)], "");
  return numbers.allFinite() ? numbers : numbers.setZero();
}

}  // namespace

JobViews job_views(std::string_view resolved_job)
{
  JobViews job;
  core::DocumentValue root;
  bool is_refused = false;
  try {
    root = core::parse_toml(resolved_job, "job");
  } catch (const InputError&) {
    is_refused = true;
  }
  const core::DocumentValue* const player = root.find("player");
  if (is_refused || player == nullptr) return job;
  if (const double zoom = numbers_in<1>(*player, "zoom").x(); zoom > 0.0) job.zoom = zoom;
  // Upper limit of the schema.
  const Eigen::Vector2d size = numbers_in<2>(*player, "display_px").cwiseMin(16384.0).cwiseMax(0.0);
  job.width_px = static_cast<int>(size.x());
  job.height_px = static_cast<int>(size.y());
  const core::DocumentValue* const render = player->find("render");
  if (render != nullptr && render->text() != nullptr) job.render = *render->text();
  const core::DocumentValue* const views = player->find("view");
  if (views == nullptr || views->list() == nullptr) return job;
  for (const core::DocumentValue& view : *views->list()) {
    job.views.push_back({static_cast<int>(numbers_in<1>(view, "number").x()), numbers_in<3>(view, "shift_mm"),
                         numbers_in<3>(view, "orientation_deg")});
  }
  return job;
}

}  // namespace vrda::view
