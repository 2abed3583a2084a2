#include "show/run_views.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda::show {
namespace {

constexpr int border_px = 2;  // between tiles
constexpr double usual_aspect = 4.0 / 3.0;

}  // namespace

std::vector<view::Viewport> tiles(std::size_t n, const view::Viewport& area)
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
  std::vector<view::Viewport> all;
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

std::vector<view::Shot> fitted_shots(const std::vector<CameraView>& views,
                                       const std::vector<view::Viewport>& areas,
                                       const std::vector<Eigen::Vector3d>& points_world_mm, double zoom)
{
  check(views.size() == areas.size(), "each view has a tile");
  std::vector<view::Shot> shots;
  for (std::size_t k = 0; k < views.size(); ++k) {
    view::FrameOptions options;
    options.aspect = 1.0 * areas[k].width / areas[k].height;
    view::CameraFit fit(views[k].R_world_camera, options);
    fit.include(points_world_mm);
    shots.push_back({view::placed_camera(fit, views[k], zoom), areas[k]});
  }
  return shots;
}

}  // namespace vrda::show
