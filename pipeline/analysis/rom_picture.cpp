// The PNG of a range of motion, or of two compared: one map per slice and the legend.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "core/canvas.hpp"
#include "analysis/rom_maps.hpp"

namespace vrda::analysis {
namespace {

using core::Canvas;
using core::Colour;
using core::TextAlign;

constexpr int most_columns = 5;
constexpr double map_px = 300.0, column_px = 390.0, row_px = 375.0, left_px = 75.0, top_px = 110.0;
constexpr double text_size_px = 18.0, heading_size_px = 30.0, legend_row_px = 30.0, outline_px = 2.0;

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

void draw_map(Canvas& canvas, const RomMaps& maps, const MapAxes& map, std::size_t slice,
              const Eigen::Vector2d& corner_px)
{
  const RomAxes& axes = maps.document.range.axes;
  const Colour ink = Colour::Zero();
  const std::size_t n_x = axes.rad[map.x].size(), n_y = axes.rad[map.y].size();
  const double x0 = edge_deg(axes, map.x, 0), x1 = edge_deg(axes, map.x, n_x);
  const double y0 = edge_deg(axes, map.y, 0), y1 = edge_deg(axes, map.y, n_y);
  const auto at_px = [&](double x_deg, double y_deg) {
    return Eigen::Vector2d(corner_px.x() + (x_deg - x0) / (x1 - x0) * map_px,
                           corner_px.y() + (y1 - y_deg) / (y1 - y0) * map_px);
  };
  std::array<std::size_t, 3> at{};
  at[map.slice] = slice;
  for (std::size_t i = 0; i < n_x; ++i) {
    for (std::size_t j = 0; j < n_y; ++j) {
      at[map.x] = i;
      at[map.y] = j;
      draw_rectangle(canvas, at_px(edge_deg(axes, map.x, i), edge_deg(axes, map.y, j + 1)),
                     at_px(edge_deg(axes, map.x, i + 1), edge_deg(axes, map.y, j)),
                     colour_of_text(maps.colour(cell_at(axes, at[0], at[1], at[2]))));
    }
  }
  for (const Outline& outline : maps.outlines) {
    for (const MapLine& line : outline_of(axes, map, slice, outline.counts)) {
      const Eigen::Vector2d from = at_px(line[0], line[1]), to = at_px(line[2], line[3]);
      constexpr double in_front = 1.0;
      canvas.draw_line({from.x(), from.y(), in_front}, {to.x(), to.y(), in_front}, outline_px,
                       colour_of_text(outline.colour));
    }
  }
  for (const std::size_t k : {std::size_t{0}, n_x / 2, n_x - 1}) {
    const double deg = deg_at(axes, map.x, k);
    canvas.draw_text({at_px(deg, y0).x(), corner_px.y() + map_px + 20.0}, text_size_px, number_text(deg),
                     TextAlign::centre, ink);
  }
  for (const std::size_t k : {std::size_t{0}, n_y / 2, n_y - 1}) {
    const double deg = deg_at(axes, map.y, k);
    canvas.draw_text({corner_px.x() - 6.0, at_px(x0, deg).y() + 6.0}, text_size_px, number_text(deg),
                     TextAlign::right, ink);
  }
  canvas.draw_text(
      corner_px + Eigen::Vector2d(0.0, -10.0), text_size_px,
      rotation_title(maps.document, map.slice) + ' ' + number_text(deg_at(axes, map.slice, slice)),
      TextAlign::left, ink);
}

}  // namespace

std::string maps_picture(const RomMaps& maps)
{
  const RomAxes& axes = maps.document.range.axes;
  const MapAxes map = map_axes(axes);
  const auto n_maps = static_cast<int>(axes.rad[map.slice].size());
  const int n_columns = std::clamp(n_maps, 2, most_columns);  // at least as wide as the legend
  const int n_rows = (n_maps + n_columns - 1) / n_columns;
  const double legend_px = top_px + n_rows * row_px;
  Canvas canvas(
      static_cast<int>(n_columns * column_px + 20.0),
      static_cast<int>(legend_px + (static_cast<double>(maps.legend.size()) + 0.5) * legend_row_px));
  const Colour ink = Colour::Zero();
  canvas.draw_text({20.0, 40.0}, heading_size_px, maps.title, TextAlign::left, ink);
  canvas.draw_text({20.0, 72.0}, text_size_px,
                   "to the right: " + rotation_title(maps.document, map.x) +
                       "; upwards: " + rotation_title(maps.document, map.y) + "; degrees",
                   TextAlign::left, ink);
  for (int k = 0; k < n_maps; ++k) {
    draw_map(canvas, maps, map, static_cast<std::size_t>(k),
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

std::string rom_picture(const RomDocument& document)
{
  return maps_picture(status_maps(document));
}

std::string comparison_picture(const RomDocument& a, const RomDocument& b)
{
  return maps_picture(comparison_maps(a, b));
}

}  // namespace vrda::analysis
