// The HTML page of a range of motion: one SVG map per slice, drawn without scripts.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/joint_kind.hpp"
#include "core/units.hpp"
#include "rom/rom_maps.hpp"

namespace vrda::rom {
namespace {

constexpr const char* status_colours[] = {"#2a7f62", "#c2500a", "#7a5fa8", "#b5892b", "#8a8f98", "#d8d8d4"};
constexpr const char* status_meanings[] = {"in range: in contact without overlap, within the limits",
                                           "contact: every place within the limits overlaps",
                                           "border: the contact is where a surface ends",
                                           "fibre: a fibre is strained beyond the limit",
                                           "nothing ahead: no surface along Delta",
                                           "not converged: the seat was not found to tolerance"};

std::string escaped(const std::string& text)
{
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string pixels(double value)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

std::string map_svg(const RomDocument& document, const MapAxes& map, std::size_t slice)
{
  const RangeOfMotion& range = document.range;
  constexpr double width = 240.0, height = 200.0, left = 46.0, bottom = 34.0, top = 6.0;
  const RomAxes& axes = range.axes;
  const std::size_t n_x = axes.rad[map.x].size(), n_y = axes.rad[map.y].size();
  const double x0 = edge_deg(axes, map.x, 0), x1 = edge_deg(axes, map.x, n_x);
  const double y0 = edge_deg(axes, map.y, 0), y1 = edge_deg(axes, map.y, n_y);
  const auto px = [&](double deg) { return left + (deg - x0) / (x1 - x0) * width; };
  const auto py = [&](double deg) { return top + (y1 - deg) / (y1 - y0) * height; };
  std::string svg = "<svg viewBox=\"0 0 " + pixels(left + width + 8) + ' ' + pixels(top + height + bottom) +
                    "\" role=\"img\" aria-label=\"Range of motion\">\n";
  std::array<std::size_t, 3> at{};
  at[map.slice] = slice;
  for (std::size_t i = 0; i < n_x; ++i) {
    for (std::size_t j = 0; j < n_y; ++j) {
      at[map.x] = i;
      at[map.y] = j;
      const RomCell& cell = range.cells[cell_at(axes, at[0], at[1], at[2])];
      const double a = px(edge_deg(axes, map.x, i)), b = px(edge_deg(axes, map.x, i + 1));
      const double c = py(edge_deg(axes, map.y, j + 1)), d = py(edge_deg(axes, map.y, j));
      svg += "<rect x=\"" + pixels(a) + "\" y=\"" + pixels(c) + "\" width=\"" + pixels(b - a + 0.3) +
             "\" height=\"" + pixels(d - c + 0.3) + "\" fill=\"" + colour_of(cell.status) + "\"" +
             (cell.status == RomStatus::in_range && !cell.is_connected ? " fill-opacity=\"0.45\"" : "") +
             "/>\n";
    }
  }
  const auto label = [&](double x, double y, const char* anchor, const std::string& text) {
    svg += "<text x=\"" + pixels(x) + "\" y=\"" + pixels(y) + "\" text-anchor=\"" + anchor + "\">" + text +
           "</text>\n";
  };
  for (const std::size_t k : {std::size_t{0}, n_x / 2, n_x - 1})
    label(px(deg_at(axes, map.x, k)), top + height + 13, "middle", number_text(deg_at(axes, map.x, k)));
  for (const std::size_t k : {std::size_t{0}, n_y / 2, n_y - 1})
    label(left - 4, py(deg_at(axes, map.y, k)) + 4, "end", number_text(deg_at(axes, map.y, k)));
  label(left + width / 2, top + height + 28, "middle", rotation_title(document, map.x) + ", degrees");
  svg += "<text transform=\"translate(11 " + pixels(top + height / 2) +
         ") rotate(-90)\" text-anchor=\"middle\">" + rotation_title(document, map.y) +
         ", degrees</text>\n</svg>\n";
  return svg;
}

std::string legend()
{
  std::string html = "<ul class=\"legend\">\n";
  for (const RomStatus status : all_rom_statuses) {
    html += std::string("<li><span style=\"background:") + colour_of(status) + "\"></span>" +
            meaning_of(status) + "</li>\n";
  }
  return html +
         "<li><span style=\"background:#2a7f62;opacity:0.45\"></span>in range, but not connected with the "
         "neutral attitude</li>\n</ul>\n";
}

std::string end_text(const RomDocument& document, const RangeEnd& end)
{
  std::string text = number_text(end.deg) + "&deg; ";
  if (end.is_of_axis) return text + "(end of the driven values)";
  text += std::string("(") + name_of(end.beyond);
  const auto name = [](const std::vector<std::string>& names, std::int32_t row) {
    return row < 0 ? std::string("-") : escaped(names[static_cast<std::size_t>(row)]);
  };
  return text + ": " + name(document.reference_names, end.component_reference) + " on " +
         name(document.moving_names, end.component_moving) + ")";
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
    html += std::string("<tr><th scope=\"row\">") + rotation_names[along.axis] + "</th>";
    if (along.is_empty) {
      html += "<td colspan=\"2\">not in range at the neutral attitude</td></tr>\n";
    } else {
      html += "<td>" + end_text(document, along.low) + "</td><td>" + end_text(document, along.high) +
              "</td></tr>\n";
    }
  }
  return html + "</tbody></table>\n";
}

constexpr const char* style = R"(<style>
:root{color-scheme:light dark;--ink:#1d2126;--paper:#fff;--rule:#d5d8dc}
@media(prefers-color-scheme:dark){:root{--ink:#e6e8eb;--paper:#16191d;--rule:#3a3f46}}
body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;color:var(--ink);background:var(--paper);max-width:1180px;margin:2rem auto;padding:0 1rem}
.maps{display:grid;grid-template-columns:repeat(auto-fill,minmax(250px,1fr));gap:1rem}
figure{margin:0;border:1px solid var(--rule);border-radius:6px;padding:.5rem}figcaption{font-size:13px}
svg text{font-size:11px;fill:var(--ink)}svg{width:100%;height:auto}
table{border-collapse:collapse}caption{text-align:left;font-weight:600}th,td{border-bottom:1px solid var(--rule);padding:.25rem .75rem;text-align:left}
.legend{list-style:none;padding:0}.legend span{display:inline-block;width:1em;height:1em;margin-right:.5em;vertical-align:-.1em}
</style>
)";

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

const char* colour_of(RomStatus status)
{
  return status_colours[static_cast<std::size_t>(status)];
}

const char* meaning_of(RomStatus status)
{
  return status_meanings[static_cast<std::size_t>(status)];
}

std::string number_text(double value)
{
  if (!std::isfinite(value)) return "none";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string rom_page(const RomDocument& document)
{
  const RangeOfMotion& range = document.range;
  const RomVolume volume = volume_of(range);
  const MapAxes map = map_axes(range.axes);
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      escaped(document.title) + ": range of motion</title>\n" + style + "</head><body>\n<h1>" +
      escaped(document.title) + ": range of motion</h1>\n";
  const std::string unit = volume.n_driven == 3   ? " degrees cubed"
                           : volume.n_driven == 2 ? " square degrees"
                                                  : " degrees";
  html += "<p>" + std::to_string(volume.n_cells) + " of " + std::to_string(range.cells.size()) +
          " attitudes in range: " + number_text(volume.volume) + unit + ", " +
          number_text(100.0 * volume.volume / volume.driven_volume) +
          " % of the driven box. Limits from the neutral seat: translation " +
          number_text(range.limits.translation_mm) + " mm across Delta, opening " +
          number_text(range.limits.opening_mm) + " mm against Delta, fibre strain " +
          number_text(range.limits.strain) + ". Delta is fixed to the " +
          (range.delta_body == DeltaBody::reference ? "reference" : "moving object") + ".</p>\n";
  html += boundary_table(document) + legend() + "<div class=\"maps\">\n";
  for (std::size_t k = 0; k < range.axes.rad[map.slice].size(); ++k) {
    html += "<figure>" + map_svg(document, map, k) + "<figcaption>" + rotation_title(document, map.slice) +
            ' ' + number_text(deg_at(range.axes, map.slice, k)) + "&deg;</figcaption></figure>\n";
  }
  return html + "</div>\n<footer><p>By " + escaped(document.program) + ".</p></footer>\n</body></html>\n";
}

}  // namespace vrda::rom
