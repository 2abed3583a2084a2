#include "follow/run_views.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda {
namespace {

constexpr int border_px = 2;  // between tiles
constexpr double usual_aspect = 4.0 / 3.0;

}  // namespace

RunView named_view(const std::string& name, View view, Side side)
{
  return {name, view_rotation(view, side), Eigen::Vector3d::Zero()};
}

RunView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& shift_mm,
                    Side side)
{
  const Eigen::Matrix3d R_turn =
      rotation_z(turn_rad.z()) * rotation_y(turn_rad.y()) * rotation_x(turn_rad.x());
  // The camera goes the other way round the joint.
  return {name, view_rotation(View::front, side) * R_turn.transpose(), shift_mm};
}

std::vector<Viewport> tiles(std::size_t n, const Viewport& area)
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
  std::vector<Viewport> all;
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

std::vector<Shot> fitted_shots(const std::vector<RunView>& views, const std::vector<Viewport>& areas,
                               const std::vector<Eigen::Vector3d>& points_world_mm, double zoom)
{
  check(views.size() == areas.size(), "each view has a place");
  std::vector<Shot> shots;
  for (std::size_t k = 0; k < views.size(); ++k) {
    FrameOptions options;
    options.aspect = 1.0 * areas[k].width / areas[k].height;
    CameraFit fit(views[k].R_world_camera, options);
    fit.include(points_world_mm);
    Camera camera = fit.camera();
    camera.half_height_tangent /= zoom;
    camera.X_world_camera.translation() -= views[k].R_world_camera * views[k].shift_camera_mm;
    shots.push_back({camera, areas[k]});
  }
  return shots;
}

}  // namespace vrda
