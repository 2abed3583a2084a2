// The HTML page and the picture of a range of motion, or of two compared: a map of each slice.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <utility>

#include "analysis/result_files.hpp"
#include "analysis/rom_files.hpp"
#include "core/canvas.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"

namespace vrda::analysis {
namespace {

// What pages and pictures have in common: axes, colours and outlines of the maps.

/// Abscissa, ordinate and slices of the maps: driven rotations first.
struct MapAxes {
  std::size_t x = 0, y = 1, slice = 2;
};

using CellChoice = std::function<bool(std::size_t cell)>;

/// A boundary curve: between the cells that count and their neighbours that do not.
struct Outline {
  CellChoice counts;
  std::string colour;
};

/// A line of a map, degrees along its abscissa and its ordinate.
using MapLine = std::array<double, 4>;

/// The maps of one page or picture. Colours are "#rrggbb".
struct RomMaps {
  std::string title;
  const RomDocument& document;  ///< of which the axes and their names are
  std::function<std::string(std::size_t cell)> colour;
  std::vector<std::pair<std::string, std::string>> legend;  ///< colour and meaning
  std::vector<Outline> outlines = {};
};

constexpr const char* status_colours[] = {"#2a7f62", "#c2500a", "#7a5fa8", "#b5892b", "#8a8f98", "#d8d8d4"};
constexpr const char* unconnected_colour = "#a0c5b9";
constexpr const char* boundary_colour = "#101418";
constexpr const char* both_colour = "#2a7f62";
constexpr const char* first_colour = "#3a6fb0";
constexpr const char* second_colour = "#d98a1f";
constexpr const char* neither_colour = "#d8d8d4";

MapAxes map_axes(const RomAxes& axes)
{
  std::vector<std::size_t> order;
  for (const bool is_driven : {true, false}) {
    for (std::size_t a = 0; a < 3; ++a) {
      if ((axes.rad[a].size() > 1) == is_driven) order.push_back(a);
    }
  }
  return {order[0], order[1], order[2]};
}

double deg_at(const RomAxes& axes, std::size_t axis, std::size_t k)
{
  return deg_from_rad(axes.rad[axis][k]);
}

/// Lower edge of the rectangle of value `k`, degrees: half way to its neighbour; of n the upper edge of the
/// last.
double edge_deg(const RomAxes& axes, std::size_t axis, std::size_t k)
{
  const std::size_t n = axes.rad[axis].size();
  if (n == 1) return deg_at(axes, axis, 0) + (k == 0 ? -0.5 : 0.5);
  if (k == 0) return 1.5 * deg_at(axes, axis, 0) - 0.5 * deg_at(axes, axis, 1);
  if (k == n) return 1.5 * deg_at(axes, axis, n - 1) - 0.5 * deg_at(axes, axis, n - 2);
  return 0.5 * (deg_at(axes, axis, k - 1) + deg_at(axes, axis, k));
}

/// Name of a rotation for the joint's kind, degrees.
std::string rotation_title(const RomDocument& document, std::size_t axis)
{
  return label_of(joint_kind(document.joint), static_cast<JointCoordinate>(axis));
}

std::string four_digits(double value)
{
  return decimals(value, "%.4g");
}

std::vector<MapLine> outline_of(const RomAxes& axes, const MapAxes& map, std::size_t slice,
                                const CellChoice& counts)
{
  const std::size_t n_x = axes.rad[map.x].size(), n_y = axes.rad[map.y].size();
  const auto counts_at = [&](std::size_t i, std::size_t j) {
    std::array<std::size_t, 3> at{};
    at[map.x] = i;
    at[map.y] = j;
    at[map.slice] = slice;
    return counts(cell_at(axes, at[0], at[1], at[2]));
  };
  const auto x = [&](std::size_t i) { return edge_deg(axes, map.x, i); };
  const auto y = [&](std::size_t j) { return edge_deg(axes, map.y, j); };
  std::vector<MapLine> lines;
  for (std::size_t i = 0; i < n_x; ++i) {
    for (std::size_t j = 0; j < n_y; ++j) {
      if (i + 1 < n_x && counts_at(i, j) != counts_at(i + 1, j))
        lines.push_back({x(i + 1), y(j), x(i + 1), y(j + 1)});
      if (j + 1 < n_y && counts_at(i, j) != counts_at(i, j + 1))
        lines.push_back({x(i), y(j + 1), x(i + 1), y(j + 1)});
    }
  }
  return lines;
}

/// The status of each cell, and the boundary of the range that is connected with the neutral attitude.
RomMaps status_maps(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  RomMaps maps{document.title + ": range of motion",
               document,
               [&range](std::size_t cell) -> std::string {
                 const RomCell& at = range.cells[cell];
                 if (at.status == RomStatus::in_range && !at.is_connected) return unconnected_colour;
                 return status_colours[static_cast<std::size_t>(at.status)];
               },
               {},
               {{[&range](std::size_t cell) { return range.cells[cell].is_connected; }, boundary_colour}}};
  for (const auto& [status, name, meaning] : rom_status_names) {
    maps.legend.emplace_back(status_colours[static_cast<std::size_t>(status)], meaning);
    if (status == RomStatus::in_range)
      maps.legend.emplace_back(unconnected_colour, "in range, but not connected with the neutral attitude");
  }
  return maps;
}

/// Which cells are in range of both, of one, of neither.
RomMaps comparison_maps(const RomDocument& a, const RomDocument& b)
{
  return {"Ranges of motion compared",
          a,
          [&a, &b](std::size_t cell) -> std::string {
            const bool in_a = a.range.cells[cell].status == RomStatus::in_range;
            const bool in_b = b.range.cells[cell].status == RomStatus::in_range;
            return in_a && in_b ? both_colour : in_a ? first_colour : in_b ? second_colour : neither_colour;
          },
          {{both_colour, "in range of both"},
           {first_colour, "only of the first: " + a.title},
           {second_colour, "only of the second: " + b.title},
           {neither_colour, "of neither"}},
          {}};
}

/// Where a map is drawn: degrees to pixels of the rectangle that its cells fill.
struct MapScale {
  double left, top, width, height;
  double x0, x1, y0, y1;

  MapScale(const RomAxes& axes, const MapAxes& map, const Eigen::Vector2d& corner_px,
           const Eigen::Vector2d& size_px)
      : left(corner_px.x()),
        top(corner_px.y()),
        width(size_px.x()),
        height(size_px.y()),
        x0(edge_deg(axes, map.x, 0)),
        x1(edge_deg(axes, map.x, axes.rad[map.x].size())),
        y0(edge_deg(axes, map.y, 0)),
        y1(edge_deg(axes, map.y, axes.rad[map.y].size()))
  {
  }
  double x(double deg) const { return left + (deg - x0) / (x1 - x0) * width; }
  double y(double deg) const { return top + (y1 - deg) / (y1 - y0) * height; }
};

/// Draws cells, outlines and the numbers at first, middle and last value of both axes, by functions of
/// `sheet`, which take pixels.
template <typename Sheet>
void draw_map(Sheet& sheet, const RomMaps& maps, const MapAxes& map, std::size_t slice, const MapScale& at_px)
{
  const RomAxes& axes = maps.document.range.axes;
  const std::size_t n_x = axes.rad[map.x].size(), n_y = axes.rad[map.y].size();
  std::array<std::size_t, 3> at{};
  at[map.slice] = slice;
  for (std::size_t i = 0; i < n_x; ++i) {
    for (std::size_t j = 0; j < n_y; ++j) {
      at[map.x] = i;
      at[map.y] = j;
      sheet.rectangle({at_px.x(edge_deg(axes, map.x, i)), at_px.y(edge_deg(axes, map.y, j + 1))},
                      {at_px.x(edge_deg(axes, map.x, i + 1)), at_px.y(edge_deg(axes, map.y, j))},
                      maps.colour(cell_at(axes, at[0], at[1], at[2])));
    }
  }
  for (const Outline& outline : maps.outlines) {
    std::vector<MapLine> lines = outline_of(axes, map, slice, outline.counts);
    for (MapLine& line : lines)
      line = {at_px.x(line[0]), at_px.y(line[1]), at_px.x(line[2]), at_px.y(line[3])};
    sheet.outline(lines, outline.colour);
  }
  for (const std::size_t k : {std::size_t{0}, n_x / 2, n_x - 1}) {
    const double deg = deg_at(axes, map.x, k);
    sheet.number_below(at_px.x(deg), at_px.top + at_px.height, four_digits(deg));
  }
  for (const std::size_t k : {std::size_t{0}, n_y / 2, n_y - 1}) {
    const double deg = deg_at(axes, map.y, k);
    sheet.number_beside(at_px.left, at_px.y(deg), four_digits(deg));
  }
}

// The page.

struct SvgSheet {
  std::string svg;

  void rectangle(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const std::string& colour)
  {
    constexpr double overlap = 0.3;  // no gaps between cells
    svg += "<rect x=\"" + decimals(low.x()) + "\" y=\"" + decimals(low.y()) + "\" width=\"" +
           decimals(high.x() - low.x() + overlap) + "\" height=\"" + decimals(high.y() - low.y() + overlap) +
           "\" fill=\"" + colour + "\"/>\n";
  }
  void outline(const std::vector<MapLine>& lines, const std::string& colour)
  {
    svg +=
        "<path fill=\"none\" stroke-width=\"1.5\" stroke-linecap=\"square\" stroke=\"" + colour + "\" d=\"";
    for (const MapLine& line : lines) {
      svg += 'M' + decimals(line[0]) + ' ' + decimals(line[1]) + 'L' + decimals(line[2]) + ' ' +
             decimals(line[3]);
    }
    svg += "\"/>\n";
  }
  void number_below(double x, double y, const std::string& text)
  {
    svg += svg_text(x, y + 13, "middle", text);
  }
  void number_beside(double x, double y, const std::string& text)
  {
    svg += svg_text(x - 4, y + 4, "end", text);
  }
};

std::string map_svg(const RomMaps& maps, const MapAxes& map, std::size_t slice)
{
  constexpr double width = 240.0, height = 200.0, left = 46.0, bottom = 34.0, top = 6.0;
  SvgSheet sheet{svg_start(left + width + 8, top + height + bottom, "Range of motion")};
  draw_map(sheet, maps, map, slice, {maps.document.range.axes, map, {left, top}, {width, height}});
  return sheet.svg +
         svg_text(left + width / 2, top + height + 28, "middle",
                  rotation_title(maps.document, map.x) + ", degrees") +
         svg_upward_text(11, top + height / 2, rotation_title(maps.document, map.y) + ", degrees") +
         "</svg>\n";
}

std::string end_text(const RomDocument& document, const RangeEnd& end)
{
  return four_digits(end.deg) + "&deg; (" + escape_markup(cause_of(document, end)) + ")";
}

// Through the neutral attitude only; boundary.csv has all of them.
std::string boundary_table(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  std::string html =
      "<table><caption>Range along each rotation, the others neutral</caption><thead><tr><th>rotation</th>"
      "<th>from</th><th>to</th></tr></thead><tbody>\n";
  for (const RangeAlong& along : boundaries_of(range)) {
    if (along.at != range.neutral) continue;
    html += "<tr><th scope=\"row\">" + rotation_title(document, along.axis) + "</th>";
    if (along.is_empty) {
      html += "<td colspan=\"2\">not in range at the neutral attitude</td></tr>\n";
    } else {
      html += "<td>" + end_text(document, along.low) + "</td><td>" + end_text(document, along.high) +
              "</td></tr>\n";
    }
  }
  return html + "</tbody></table>\n";
}

std::string unit_of(const RomVolume& volume)
{
  return volume.n_driven == 3 ? "degrees cubed" : volume.n_driven == 2 ? "square degrees" : "degrees";
}

std::string limits_text(const RangeOfMotion& range)
{
  const auto limit = [](double value, const char* unit) {
    return std::isfinite(value) ? four_digits(value) + unit : "not limited";
  };
  return "translation across Delta " + limit(range.limits.translation_mm, " mm") +
         ", opening against Delta " + limit(range.limits.opening_mm, " mm") + ", fibre strain " +
         limit(range.limits.strain, "") + "; Delta is fixed to the " +
         (range.delta_body == DeltaBody::reference ? "reference" : "moving object");
}

constexpr const char* style =
    R"(.maps{display:grid;grid-template-columns:repeat(auto-fill,minmax(250px,1fr));gap:1rem}
figure{margin:0;border:1px solid var(--rule);border-radius:6px;padding:.5rem}figcaption{font-size:13px}
svg text{font-size:11px;fill:var(--ink)}svg{width:100%;height:auto}
table{border-collapse:collapse}caption{text-align:left;font-weight:600}th,td{border-bottom:1px solid var(--rule);padding:.25rem .75rem;text-align:left}
td.number{text-align:right}
.legend{list-style:none;padding:0}.legend span{display:inline-block;width:1em;height:1em;margin-right:.5em;vertical-align:-.1em}
)";

std::string volume_row(const std::string& name, const RomVolume& volume)
{
  const auto number = [](const std::string& text) { return "<td class=\"number\">" + text + "</td>"; };
  return "<tr><th scope=\"row\">" + name + "</th>" + number(std::to_string(volume.n_cells)) +
         number(four_digits(volume.volume)) +
         number(four_digits(100.0 * volume.volume / volume.driven_volume)) + "</tr>\n";
}

std::string maps_page(const RomMaps& maps, const std::string& introduction)
{
  const RomAxes& axes = maps.document.range.axes;
  const MapAxes map = map_axes(axes);
  std::string html = introduction + "<ul class=\"legend\">\n";
  for (const auto& [colour, meaning] : maps.legend)
    html += "<li><span style=\"background:" + colour + "\"></span>" + escape_markup(meaning) + "</li>\n";
  html += "</ul>\n<div class=\"maps\">\n";
  for (std::size_t k = 0; k < axes.rad[map.slice].size(); ++k) {
    html += "<figure>" + map_svg(maps, map, k) + "<figcaption>" + rotation_title(maps.document, map.slice) +
            ' ' + four_digits(deg_at(axes, map.slice, k)) + "&deg;</figcaption></figure>\n";
  }
  return html_page({maps.title, "1180px", style, maps.document.program}, html + "</div>\n");
}

// The picture.

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

struct CanvasSheet {
  Canvas& canvas;
  Colour ink = Colour::Zero();

  void rectangle(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const std::string& colour)
  {
    const Eigen::Vector3d a(low.x(), low.y(), 0.0), b(high.x(), low.y(), 0.0), c(high.x(), high.y(), 0.0),
        d(low.x(), high.y(), 0.0);
    canvas.draw_triangle({a, b, c}, colour_of_text(colour));
    canvas.draw_triangle({a, c, d}, colour_of_text(colour));
  }
  void outline(const std::vector<MapLine>& lines, const std::string& colour)
  {
    constexpr double in_front = 1.0;
    for (const MapLine& line : lines)
      canvas.draw_line({line[0], line[1], in_front}, {line[2], line[3], in_front}, outline_px,
                       colour_of_text(colour));
  }
  void number_below(double x, double y, const std::string& text)
  {
    canvas.draw_text({x, y + 20.0}, text_size_px, text, TextAlign::centre, ink);
  }
  void number_beside(double x, double y, const std::string& text)
  {
    canvas.draw_text({x - 6.0, y + 6.0}, text_size_px, text, TextAlign::right, ink);
  }
};

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
  CanvasSheet sheet{canvas};
  canvas.draw_text({20.0, 40.0}, heading_size_px, maps.title, TextAlign::left, sheet.ink);
  canvas.draw_text({20.0, 72.0}, text_size_px,
                   "to the right: " + rotation_title(maps.document, map.x) +
                       "; upwards: " + rotation_title(maps.document, map.y) + "; degrees",
                   TextAlign::left, sheet.ink);
  for (int k = 0; k < n_maps; ++k) {
    const auto slice = static_cast<std::size_t>(k);
    const Eigen::Vector2d corner_px(left_px + (k % n_columns) * column_px,
                                    top_px + 15.0 + (k / n_columns) * row_px);
    draw_map(sheet, maps, map, slice, {axes, map, corner_px, {map_px, map_px}});
    canvas.draw_text(
        corner_px + Eigen::Vector2d(0.0, -10.0), text_size_px,
        rotation_title(maps.document, map.slice) + ' ' + four_digits(deg_at(axes, map.slice, slice)),
        TextAlign::left, sheet.ink);
  }
  double y = legend_px;
  for (const auto& [colour, meaning] : maps.legend) {
    y += legend_row_px;
    sheet.rectangle({20.0, y - 18.0}, {42.0, y + 2.0}, colour);
    canvas.draw_text({54.0, y}, text_size_px, meaning, TextAlign::left, sheet.ink);
  }
  return canvas.png();
}

}  // namespace

std::string rom_page(const RomDocument& document)
{
  const RomVolume volume = volume_of(document.range);
  return maps_page(status_maps(document),
                   "<p>" + std::to_string(volume.n_cells) + " of " +
                       std::to_string(document.range.cells.size()) +
                       " attitudes in range: " + four_digits(volume.volume) + ' ' + unit_of(volume) + ", " +
                       four_digits(100.0 * volume.volume / volume.driven_volume) +
                       " % of the driven box. Limits from the neutral seat: " + limits_text(document.range) +
                       ".</p>\n" + boundary_table(document));
}

std::string comparison_page(const RomDocument& a, const RomDocument& b)
{
  const RomComparison found = compare_ranges(a.range, b.range, b.title);
  return maps_page(comparison_maps(a, b),
                   "<p>First: " + escape_markup(a.title) + "; " + limits_text(a.range) +
                       ".<br>Second: " + escape_markup(b.title) + "; " + limits_text(b.range) +
                       ".</p>\n<table><thead><tr><th>in range of</th><th>attitudes</th><th>" +
                       unit_of(found.a) + "</th><th>% of the driven box</th></tr></thead><tbody>\n" +
                       volume_row("the first", found.a) + volume_row("the second", found.b) +
                       volume_row("both", found.both) + volume_row("the first only", found.only_a) +
                       volume_row("the second only", found.only_b) + "</tbody></table>\n");
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
