// The HTML page of a range of motion, or of two compared.
#include <cmath>
#include <cstdio>

#include "core/text.hpp"
#include "analysis/rom_maps.hpp"

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

}  // namespace vrda::analysis
