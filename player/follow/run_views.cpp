#include "follow/run_views.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "documents/document.hpp"
#include "loop/loop.hpp"

namespace vrda::follow {
namespace {

constexpr int border_px = 2;  // between tiles
constexpr double usual_aspect = 4.0 / 3.0;

}  // namespace

RunView named_view(const std::string& name, scene::View view, Side side)
{
  return {name, scene::view_rotation(view, side), Eigen::Vector3d::Zero()};
}

RunView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& shift_mm,
                    Side side)
{
  const Eigen::Matrix3d R_turn =
      rotation_z(turn_rad.z()) * rotation_y(turn_rad.y()) * rotation_x(turn_rad.x());
  // Rotating the joint equals the inverse rotation of the camera.
  return {name, scene::view_rotation(scene::View::front, side) * R_turn.transpose(), shift_mm};
}

std::vector<optics::Viewport> tiles(std::size_t n, const optics::Viewport& area)
{
  check(n > 0, "there is at least one view");
  const auto count = static_cast<int>(n);
  int n_columns = 1;
  double best = 0.0;
  for (int columns = 1; columns <= count; ++columns) {
    const int rows = (count + columns - 1) / columns;
    const double size = std::min(1.0 * area.width / columns, usual_aspect * area.height / rows);
    if (size <= best) continue;
    best = size;
    n_columns = columns;
  }
  const int n_rows = (count + n_columns - 1) / n_columns;
  std::vector<optics::Viewport> all;
  for (int k = 0; k < count; ++k) {
    const int row = k / n_columns, column = k % n_columns;
    // The last row's tiles share its width.
    const int columns = row + 1 < n_rows ? n_columns : count - row * n_columns;
    const int left = area.width * column / columns, right = area.width * (column + 1) / columns;
    const int top = area.height * row / n_rows, bottom = area.height * (row + 1) / n_rows;
    all.push_back({area.x + left, area.y + top, std::max(1, right - left - border_px),
                   std::max(1, bottom - top - border_px)});
  }
  return all;
}

std::vector<render::Shot> fitted_shots(const std::vector<RunView>& views,
                                       const std::vector<optics::Viewport>& areas,
                                       const std::vector<Eigen::Vector3d>& points_world_mm, double zoom)
{
  check(views.size() == areas.size(), "each view has a tile");
  std::vector<render::Shot> shots;
  for (std::size_t k = 0; k < views.size(); ++k) {
    scene::FrameOptions options;
    options.aspect = 1.0 * areas[k].width / areas[k].height;
    scene::CameraFit fit(views[k].R_world_camera, options);
    fit.include(points_world_mm);
    scene::Camera camera = fit.camera();
    camera.half_height_tangent /= zoom;
    camera.X_world_camera.translation() -= views[k].R_world_camera * views[k].shift_camera_mm;
    shots.push_back({camera, areas[k]});
  }
  return shots;
}

namespace {

/// The number or the list of n numbers of a key; all zero if it has another form.
template <int n>
Eigen::Matrix<double, n, 1> numbers_in(const documents::DocumentValue& table, std::string_view key)
{
  using List = documents::DocumentValue::List;
  const documents::DocumentValue* const value = table.find(key);
  const List list = value == nullptr ? List{} : value->list() == nullptr ? List{*value} : *value->list();
  Eigen::Matrix<double, n, 1> numbers = Eigen::Matrix<double, n, 1>::Zero();
  if (list.size() != n || !std::ranges::all_of(list, &documents::DocumentValue::is_number)) return numbers;
  for (Eigen::Index i = 0; i < n; ++i)
    numbers[i] = documents::number_at(list[static_cast<std::size_t>(i)], "");
  return numbers.allFinite() ? numbers : numbers.setZero();
}

}  // namespace

JobViews job_views(std::string_view resolved_job)
{
  JobViews job;
  documents::DocumentValue root;
  const auto refused = loop::catch_input_error([&] { root = documents::parse_toml(resolved_job, "job"); });
  const documents::DocumentValue* const player = root.find("player");
  if (refused || player == nullptr) return job;
  if (const double zoom = numbers_in<1>(*player, "zoom").x(); zoom > 0.0) job.zoom = zoom;
  // Upper limit of the schema.
  const Eigen::Vector2d size = numbers_in<2>(*player, "display_px").cwiseMin(16384.0).cwiseMax(0.0);
  job.width_px = static_cast<int>(size.x());
  job.height_px = static_cast<int>(size.y());
  const documents::DocumentValue* const render = player->find("render");
  if (render != nullptr && render->text() != nullptr) job.render = *render->text();
  const documents::DocumentValue* const views = player->find("view");
  if (views == nullptr || views->list() == nullptr) return job;
  for (const documents::DocumentValue& view : *views->list()) {
    job.views.push_back({static_cast<int>(numbers_in<1>(view, "number").x()), numbers_in<3>(view, "shift_mm"),
                         numbers_in<3>(view, "orientation_deg")});
  }
  return job;
}

}  // namespace vrda::follow
