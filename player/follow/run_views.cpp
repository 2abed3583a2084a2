#include "follow/run_views.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/error.hpp"

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

/// "key = value" of one line; empty for any other line.
struct Entry {
  std::string_view key, value;
};

Entry entry_of(std::string_view line)
{
  constexpr std::string_view equals = " = ";
  const std::size_t at = line.find(equals);
  if (at == std::string_view::npos) return {};
  return {line.substr(0, at), line.substr(at + equals.size())};
}

/// Parses the number at the start of `text` and removes it from `text`.
std::optional<double> take_number(std::string_view& text)
{
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// The first n numbers of a list; all zero if there are fewer.
template <int n>
Eigen::Matrix<double, n, 1> numbers_of(std::string_view text)
{
  Eigen::Matrix<double, n, 1> numbers = Eigen::Matrix<double, n, 1>::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t at = text.find_first_not_of("[, ");
    if (at == std::string_view::npos) return Eigen::Matrix<double, n, 1>::Zero();
    text.remove_prefix(at);
    const std::optional<double> value = take_number(text);
    if (!value) return Eigen::Matrix<double, n, 1>::Zero();
    numbers[i] = *value;
  }
  return numbers;
}

void read(JobViews& job, const Entry& entry)
{
  if (entry.key == "zoom") {
    std::string_view text = entry.value;
    const double zoom = take_number(text).value_or(1.0);
    if (zoom > 0.0) job.zoom = zoom;
  }
  if (entry.key == "display_px") {
    // Upper limit of the schema.
    const Eigen::Vector2d size = numbers_of<2>(entry.value).cwiseMin(16384.0).cwiseMax(0.0);
    job.width_px = static_cast<int>(size.x());
    job.height_px = static_cast<int>(size.y());
  }
  if (entry.key == "render" && entry.value.size() > 2)
    job.render = entry.value.substr(1, entry.value.size() - 2);
}

void read(JobView& view, const Entry& entry)
{
  std::string_view text = entry.value;
  if (entry.key == "number") view.number = static_cast<int>(take_number(text).value_or(0.0));
  if (entry.key == "shift_mm") view.shift_mm = numbers_of<3>(text);
  if (entry.key == "orientation_deg") view.orientation_deg = numbers_of<3>(text);
}

}  // namespace

JobViews job_views(std::string_view resolved_job)
{
  enum class Table { other, player, view };
  JobViews job;
  Table table = Table::other;
  while (!resolved_job.empty()) {
    const std::size_t end = resolved_job.find('\n');
    const std::string_view line = resolved_job.substr(0, end);
    resolved_job.remove_prefix(end == std::string_view::npos ? resolved_job.size() : end + 1);
    if (line == "[[player.view]]") {
      table = Table::view;
      job.views.emplace_back();
    } else if (line.starts_with('[')) {
      table = line == "[player]" ? Table::player : Table::other;
    } else if (table == Table::player) {
      read(job, entry_of(line));
    } else if (table == Table::view) {
      read(job.views.back(), entry_of(line));
    }
  }
  return job;
}

}  // namespace vrda::follow
