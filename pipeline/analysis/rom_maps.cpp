// The maps of a range of motion, or of two compared, and their picture.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "analysis/rom_files.hpp"
#include "core/canvas.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"

namespace vrda::analysis {
namespace {

using core::Canvas;
using core::Colour;
using core::TextAlign;

// By RomStatus.
constexpr const char* status_colours[] = {"#2a7f62", "#c2500a", "#7a5fa8", "#b5892b", "#8a8f98", "#d8d8d4"};

// Driven rotations first.
std::array<std::size_t, 3> map_axes(const RomAxes& axes)
{
  std::array<std::size_t, 3> order{0, 1, 2};
  std::stable_partition(order.begin(), order.end(), [&](std::size_t a) { return axes.rad[a].size() > 1; });
  return order;
}

// Half way between neighbours, and as far beyond the first and the last value.
std::vector<double> edges_of(const std::vector<double>& deg)
{
  const std::size_t n = deg.size();
  if (n == 1) return {deg[0] - 0.5, deg[0] + 0.5};
  std::vector<double> edges{1.5 * deg[0] - 0.5 * deg[1]};
  for (std::size_t k = 1; k < n; ++k) edges.push_back(0.5 * (deg[k - 1] + deg[k]));
  edges.push_back(1.5 * deg[n - 1] - 0.5 * deg[n - 2]);
  return edges;
}

// Between the cells that count and their neighbours that do not.
std::vector<RomMaps::Line> outline_of(const RomMaps& maps, const std::function<bool(int, int)>& counts)
{
  const auto& x = maps.x_edges_deg;
  const auto& y = maps.y_edges_deg;
  const int n_x = static_cast<int>(maps.x_deg.size()), n_y = static_cast<int>(maps.y_deg.size());
  std::vector<RomMaps::Line> lines;
  for (int i = 0; i < n_x; ++i) {
    for (int j = 0; j < n_y; ++j) {
      const auto right = static_cast<std::size_t>(i) + 1, top = static_cast<std::size_t>(j) + 1;
      if (i + 1 < n_x && counts(i, j) != counts(i + 1, j))
        lines.push_back({x[right], y[top - 1], x[right], y[top]});
      if (j + 1 < n_y && counts(i, j) != counts(i, j + 1))
        lines.push_back({x[right - 1], y[top], x[right], y[top]});
    }
  }
  return lines;
}

/// Row of the legend of a cell, and whether it is within the outline.
struct Kind {
  std::size_t row = 0;
  bool is_within = false;
};

RomMaps maps_of(const RomDocument& document, const std::function<Kind(std::size_t cell)>& kind_of_cell)
{
  const RomAxes& axes = document.range.axes;
  const std::array<std::size_t, 3> map = map_axes(axes);
  RomMaps maps;
  for (std::size_t k = 0; k < 3; ++k)
    maps.titles[k] = label_of(joint_kind(document.joint), static_cast<JointCoordinate>(map[k]));
  maps.x_deg = degrees(axes.rad[map[0]]);
  maps.y_deg = degrees(axes.rad[map[1]]);
  maps.slice_deg = degrees(axes.rad[map[2]]);
  maps.x_edges_deg = edges_of(maps.x_deg);
  maps.y_edges_deg = edges_of(maps.y_deg);
  for (std::size_t slice = 0; slice < maps.slice_deg.size(); ++slice) {
    const auto kind_at = [&](std::size_t i, std::size_t j) {
      std::array<std::size_t, 3> at{};
      at[map[0]] = i;
      at[map[1]] = j;
      at[map[2]] = slice;
      return kind_of_cell(cell_at(axes, at[0], at[1], at[2]));
    };
    std::vector<std::vector<std::size_t>>& cells = maps.cells.emplace_back(maps.x_deg.size());
    for (std::size_t i = 0; i < maps.x_deg.size(); ++i) {
      for (std::size_t j = 0; j < maps.y_deg.size(); ++j) cells[i].push_back(kind_at(i, j).row);
    }
    maps.outlines.push_back(outline_of(maps, [&](int i, int j) {
      return kind_at(static_cast<std::size_t>(i), static_cast<std::size_t>(j)).is_within;
    }));
  }
  return maps;
}

// One map per slice and the legend.

constexpr int most_columns = 5;
constexpr double map_px = 300.0, column_px = 390.0, row_px = 375.0, left_px = 75.0, top_px = 110.0;
constexpr double text_size_px = 18.0, heading_size_px = 30.0, legend_row_px = 30.0, outline_px = 2.0;

std::string number_text(double value)
{
  return rounded_text(value, 4);
}

Colour colour_of_text(const std::string& hex)
{
  const auto part = [&hex](std::size_t at) {
    return static_cast<float>(std::strtol(hex.substr(at, 2).c_str(), nullptr, 16)) / 255.0F;
  };
  return {part(1), part(3), part(5)};
}

void draw_rectangle(Canvas& canvas, const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                    const Colour& colour)
{
  const Eigen::Vector3d a(low.x(), low.y(), 0.0), b(high.x(), low.y(), 0.0), c(high.x(), high.y(), 0.0),
      d(low.x(), high.y(), 0.0);
  canvas.draw_triangle({a, b, c}, colour);
  canvas.draw_triangle({a, c, d}, colour);
}

void draw_map(Canvas& canvas, const RomMaps& maps, std::size_t slice, const Eigen::Vector2d& corner_px)
{
  const Colour ink = Colour::Zero();
  const auto &x = maps.x_edges_deg, &y = maps.y_edges_deg;
  const double x0 = x.front(), x1 = x.back(), y0 = y.front(), y1 = y.back();
  const auto at_px = [&](double x_deg, double y_deg) {
    return Eigen::Vector2d(corner_px.x() + (x_deg - x0) / (x1 - x0) * map_px,
                           corner_px.y() + (y1 - y_deg) / (y1 - y0) * map_px);
  };
  for (std::size_t i = 0; i < maps.x_deg.size(); ++i) {
    for (std::size_t j = 0; j < maps.y_deg.size(); ++j)
      draw_rectangle(canvas, at_px(x[i], y[j + 1]), at_px(x[i + 1], y[j]),
                     colour_of_text(maps.legend[maps.cells[slice][i][j]].first));
  }
  for (const RomMaps::Line& line : maps.outlines[slice]) {
    const Eigen::Vector2d from = at_px(line[0], line[1]), to = at_px(line[2], line[3]);
    constexpr double in_front = 1.0;
    canvas.draw_line({from.x(), from.y(), in_front}, {to.x(), to.y(), in_front}, outline_px,
                     colour_of_text(RomMaps::outline_colour));
  }
  const auto of_first_middle_last = [](const std::vector<double>& deg) {
    return std::array{deg.front(), deg[deg.size() / 2], deg.back()};
  };
  for (const double deg : of_first_middle_last(maps.x_deg))
    canvas.draw_text({at_px(deg, y0).x(), corner_px.y() + map_px + 20.0}, text_size_px, number_text(deg),
                     TextAlign::centre, ink);
  for (const double deg : of_first_middle_last(maps.y_deg))
    canvas.draw_text({corner_px.x() - 6.0, at_px(x0, deg).y() + 6.0}, text_size_px, number_text(deg),
                     TextAlign::right, ink);
  canvas.draw_text(corner_px + Eigen::Vector2d(0.0, -10.0), text_size_px,
                   maps.titles[2] + ' ' + number_text(maps.slice_deg[slice]), TextAlign::left, ink);
}

}  // namespace

RomMaps status_maps(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  constexpr std::size_t unconnected = 1;  // row of the legend, after that of the range
  RomMaps maps = maps_of(document, [&](std::size_t cell) -> Kind {
    const RomCell& at = range.cells[cell];
    const auto status = static_cast<std::size_t>(at.status);
    const bool is_in_range = at.status == RomStatus::in_range;
    return {is_in_range ? (at.is_connected ? 0 : unconnected) : status + 1, at.is_connected};
  });
  maps.title = document.title + ": range of motion";
  for (const Named<RomStatus>& status : rom_status_names) {
    maps.legend.emplace_back(status_colours[static_cast<std::size_t>(status.value)], status.meaning);
    if (status.value == RomStatus::in_range)
      maps.legend.emplace_back("#a0c5b9", "in range, but not connected with the neutral attitude");
  }
  return maps;
}

RomMaps comparison_maps(const RomDocument& a, const RomDocument& b)
{
  RomMaps maps = maps_of(a, [&](std::size_t cell) -> Kind {
    const bool in_a = a.range.cells[cell].status == RomStatus::in_range;
    const bool in_b = b.range.cells[cell].status == RomStatus::in_range;
    return {in_a && in_b ? 0U : in_a ? 1U : in_b ? 2U : 3U, false};
  });
  maps.title = "Ranges of motion compared";
  maps.legend = {{"#2a7f62", "in range of both"},
                 {"#3a6fb0", "only of the first: " + a.title},
                 {"#d98a1f", "only of the second: " + b.title},
                 {"#d8d8d4", "of neither"}};
  return maps;
}

std::string maps_picture(const RomMaps& maps)
{
  const auto n_maps = static_cast<int>(maps.slice_deg.size());
  const int n_columns = std::clamp(n_maps, 2, most_columns);  // at least as wide as the legend
  const int n_rows = (n_maps + n_columns - 1) / n_columns;
  const double legend_px = top_px + n_rows * row_px;
  Canvas canvas(
      static_cast<int>(n_columns * column_px + 20.0),
      static_cast<int>(legend_px + (static_cast<double>(maps.legend.size()) + 0.5) * legend_row_px));
  const Colour ink = Colour::Zero();
  canvas.draw_text({20.0, 40.0}, heading_size_px, maps.title, TextAlign::left, ink);
  canvas.draw_text({20.0, 72.0}, text_size_px,
                   "to the right: " + maps.titles[0] + "; upwards: " + maps.titles[1] + "; degrees",
                   TextAlign::left, ink);
  for (int k = 0; k < n_maps; ++k) {
    draw_map(canvas, maps, static_cast<std::size_t>(k),
             {left_px + (k % n_columns) * column_px, top_px + 15.0 + (k / n_columns) * row_px});
  }
  double y = legend_px;
  for (const auto& [colour, meaning] : maps.legend) {
    y += legend_row_px;
    draw_rectangle(canvas, {20.0, y - 18.0}, {42.0, y + 2.0}, colour_of_text(colour));
    canvas.draw_text({54.0, y}, text_size_px, meaning, TextAlign::left, ink);
  }
  return canvas.png();
}

}  // namespace vrda::analysis
