#include "analysis/rom_maps.hpp"

#include <cmath>
#include <cstdio>

#include "model/joint_kind.hpp"
#include "core/units.hpp"

namespace vrda::analysis {
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
