// The HTML page of a range of motion, or of two compared.
#include "analysis/rom_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/canvas.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"

namespace vrda::analysis {
namespace {

constexpr double map_width = 240.0, map_height = 200.0, map_left = 46.0, map_bottom = 34.0, map_top = 6.0;

std::string pixels(double value)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

// Degrees to pixels of one map.
struct MapScale {
  double x0, x1, y0, y1;

  MapScale(const RomAxes& axes, const MapAxes& map)
      : x0(edge_deg(axes, map.x, 0)),
        x1(edge_deg(axes, map.x, axes.rad[map.x].size())),
        y0(edge_deg(axes, map.y, 0)),
        y1(edge_deg(axes, map.y, axes.rad[map.y].size()))
  {
  }
  double x(double deg) const { return map_left + (deg - x0) / (x1 - x0) * map_width; }
  double y(double deg) const { return map_top + (y1 - deg) / (y1 - y0) * map_height; }
};

std::string cells_svg(const RomMaps& maps, const MapAxes& map, std::size_t slice, const MapScale& at_px)
{
  const RomAxes& axes = maps.document.range.axes;
  std::string svg;
  std::array<std::size_t, 3> at{};
  at[map.slice] = slice;
  for (std::size_t i = 0; i < axes.rad[map.x].size(); ++i) {
    for (std::size_t j = 0; j < axes.rad[map.y].size(); ++j) {
      at[map.x] = i;
      at[map.y] = j;
      const double left = at_px.x(edge_deg(axes, map.x, i)), top = at_px.y(edge_deg(axes, map.y, j + 1));
      svg += "<rect x=\"" + pixels(left) + "\" y=\"" + pixels(top) + "\" width=\"" +
             pixels(at_px.x(edge_deg(axes, map.x, i + 1)) - left + 0.3) + "\" height=\"" +
             pixels(at_px.y(edge_deg(axes, map.y, j)) - top + 0.3) + "\" fill=\"" +
             maps.colour(cell_at(axes, at[0], at[1], at[2])) + "\"/>\n";
    }
  }
  for (const Outline& outline : maps.outlines) {
    svg += "<path fill=\"none\" stroke-width=\"1.5\" stroke-linecap=\"square\" stroke=\"" + outline.colour +
           "\" d=\"";
    for (const MapLine& line : outline_of(axes, map, slice, outline.counts)) {
      svg += 'M' + pixels(at_px.x(line[0])) + ' ' + pixels(at_px.y(line[1])) + 'L' +
             pixels(at_px.x(line[2])) + ' ' + pixels(at_px.y(line[3]));
    }
    svg += "\"/>\n";
  }
  return svg;
}

std::string map_svg(const RomMaps& maps, const MapAxes& map, std::size_t slice)
{
  const RomAxes& axes = maps.document.range.axes;
  const MapScale at_px(axes, map);
  std::string svg = "<svg viewBox=\"0 0 " + pixels(map_left + map_width + 8) + ' ' +
                    pixels(map_top + map_height + map_bottom) +
                    "\" role=\"img\" aria-label=\"Range of motion\">\n" + cells_svg(maps, map, slice, at_px);
  const auto label = [&](double x, double y, const char* anchor, const std::string& text) {
    svg += "<text x=\"" + pixels(x) + "\" y=\"" + pixels(y) + "\" text-anchor=\"" + anchor + "\">" + text +
           "</text>\n";
  };
  const std::size_t n_x = axes.rad[map.x].size(), n_y = axes.rad[map.y].size();
  for (const std::size_t k : {std::size_t{0}, n_x / 2, n_x - 1})
    label(at_px.x(deg_at(axes, map.x, k)), map_top + map_height + 13, "middle",
          number_text(deg_at(axes, map.x, k)));
  for (const std::size_t k : {std::size_t{0}, n_y / 2, n_y - 1})
    label(map_left - 4, at_px.y(deg_at(axes, map.y, k)) + 4, "end", number_text(deg_at(axes, map.y, k)));
  label(map_left + map_width / 2, map_top + map_height + 28, "middle",
        rotation_title(maps.document, map.x) + ", degrees");
  return svg + "<text transform=\"translate(11 " + pixels(map_top + map_height / 2) +
         ") rotate(-90)\" text-anchor=\"middle\">" + rotation_title(maps.document, map.y) +
         ", degrees</text>\n</svg>\n";
}

std::string end_text(const RomDocument& document, const RangeEnd& end)
{
  return number_text(end.deg) + "&deg; (" + escape_markup(cause_of(document, end)) + ")";
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
    return std::isfinite(value) ? number_text(value) + unit : "not limited";
  };
  return "translation across Delta " + limit(range.limits.translation_mm, " mm") +
         ", opening against Delta " + limit(range.limits.opening_mm, " mm") + ", fibre strain " +
         limit(range.limits.strain, "") + "; Delta is fixed to the " +
         (range.delta_body == DeltaBody::reference ? "reference" : "moving object");
}

constexpr const char* style = R"(<style>
:root{color-scheme:light dark;--ink:#1d2126;--paper:#fff;--rule:#d5d8dc}
@media(prefers-color-scheme:dark){:root{--ink:#e6e8eb;--paper:#16191d;--rule:#3a3f46}}
body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;color:var(--ink);background:var(--paper);max-width:1180px;margin:2rem auto;padding:0 1rem}
.maps{display:grid;grid-template-columns:repeat(auto-fill,minmax(250px,1fr));gap:1rem}
figure{margin:0;border:1px solid var(--rule);border-radius:6px;padding:.5rem}figcaption{font-size:13px}
svg text{font-size:11px;fill:var(--ink)}svg{width:100%;height:auto}
table{border-collapse:collapse}caption{text-align:left;font-weight:600}th,td{border-bottom:1px solid var(--rule);padding:.25rem .75rem;text-align:left}
td.number{text-align:right}
.legend{list-style:none;padding:0}.legend span{display:inline-block;width:1em;height:1em;margin-right:.5em;vertical-align:-.1em}
</style>
)";

std::string volume_row(const std::string& name, const RomVolume& volume)
{
  const auto number = [](const std::string& text) { return "<td class=\"number\">" + text + "</td>"; };
  return "<tr><th scope=\"row\">" + name + "</th>" + number(std::to_string(volume.n_cells)) +
         number(number_text(volume.volume)) +
         number(number_text(100.0 * volume.volume / volume.driven_volume)) + "</tr>\n";
}

}  // namespace

std::string maps_page(const RomMaps& maps, const std::string& introduction)
{
  const RomAxes& axes = maps.document.range.axes;
  const MapAxes map = map_axes(axes);
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      escape_markup(maps.title) + "</title>\n" + style + "</head><body>\n<h1>" + escape_markup(maps.title) +
      "</h1>\n" + introduction + "<ul class=\"legend\">\n";
  for (const auto& [colour, meaning] : maps.legend)
    html += "<li><span style=\"background:" + colour + "\"></span>" + escape_markup(meaning) + "</li>\n";
  html += "</ul>\n<div class=\"maps\">\n";
  for (std::size_t k = 0; k < axes.rad[map.slice].size(); ++k) {
    html += "<figure>" + map_svg(maps, map, k) + "<figcaption>" + rotation_title(maps.document, map.slice) +
            ' ' + number_text(deg_at(axes, map.slice, k)) + "&deg;</figcaption></figure>\n";
  }
  return html + "</div>\n<footer><p>By " + escape_markup(maps.document.program) +
         ".</p></footer>\n</body></html>\n";
}

std::string rom_page(const RomDocument& document)
{
  const RomVolume volume = volume_of(document.range);
  return maps_page(status_maps(document),
                   "<p>" + std::to_string(volume.n_cells) + " of " +
                       std::to_string(document.range.cells.size()) +
                       " attitudes in range: " + number_text(volume.volume) + ' ' + unit_of(volume) + ", " +
                       number_text(100.0 * volume.volume / volume.driven_volume) +
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

// The PNG of a range of motion, or of two compared: one map per slice and the legend.

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

namespace {

constexpr const char* status_colours[] = {"#2a7f62", "#c2500a", "#7a5fa8", "#b5892b", "#8a8f98", "#d8d8d4"};
constexpr const char* status_meanings[] = {"in range: in contact without overlap, within the limits",
                                           "contact: every position within the limits overlaps",
                                           "border: the contact is where a surface ends",
                                           "fibre: a fibre is strained beyond the limit",
                                           "nothing ahead: no surface along Delta",
                                           "not converged: the seat was not found to tolerance"};
constexpr const char* unconnected_colour = "#a0c5b9";
constexpr const char* boundary_colour = "#101418";
constexpr const char* both_colour = "#2a7f62";
constexpr const char* first_colour = "#3a6fb0";
constexpr const char* second_colour = "#d98a1f";
constexpr const char* neither_colour = "#d8d8d4";

CellChoice connected_cells(const RangeOfMotion& range)
{
  return [&range](std::size_t cell) { return range.cells[cell].is_connected; };
}

}  // namespace

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

double edge_deg(const RomAxes& axes, std::size_t axis, std::size_t k)
{
  const std::size_t n = axes.rad[axis].size();
  if (n == 1) return deg_at(axes, axis, 0) + (k == 0 ? -0.5 : 0.5);
  if (k == 0) return 1.5 * deg_at(axes, axis, 0) - 0.5 * deg_at(axes, axis, 1);
  if (k == n) return 1.5 * deg_at(axes, axis, n - 1) - 0.5 * deg_at(axes, axis, n - 2);
  return 0.5 * (deg_at(axes, axis, k - 1) + deg_at(axes, axis, k));
}

std::string rotation_title(const RomDocument& document, std::size_t axis)
{
  return label_of(joint_kind(document.joint), static_cast<JointCoordinate>(axis));
}

std::string number_text(double value)
{
  if (!std::isfinite(value)) return "none";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
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
               {{connected_cells(range), boundary_colour}}};
  for (const RomStatus status : all_rom_statuses) {
    const auto code = static_cast<std::size_t>(status);
    maps.legend.emplace_back(status_colours[code], status_meanings[code]);
    if (status == RomStatus::in_range)
      maps.legend.emplace_back(unconnected_colour, "in range, but not connected with the neutral attitude");
  }
  return maps;
}

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

}  // namespace vrda::analysis
