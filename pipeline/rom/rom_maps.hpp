/// What page and picture of a range of motion have in common: a map of each slice, its axes and colours.
#pragma once

#include <array>
#include <string>

#include "rom/rom_files.hpp"

namespace vrda::rom {

/// Abscissa, ordinate and slices of the maps: driven rotations first.
struct MapAxes {
  std::size_t x = 0, y = 1, slice = 2;
};
MapAxes map_axes(const RomAxes& axes);

double deg_at(const RomAxes& axes, std::size_t axis, std::size_t k);
/// Lower edge of the rectangle of value `k`, degrees: half way to its neighbour; of n the upper edge of the
/// last.
double edge_deg(const RomAxes& axes, std::size_t axis, std::size_t k);

/// Name of a rotation in the words of the joint's kind, degrees.
std::string rotation_title(const RomDocument& document, std::size_t axis);

/// "#rrggbb" of a status, and what it means.
const char* colour_of(RomStatus status);
const char* meaning_of(RomStatus status);
/// Opacity of cells in range that are not connected with the neutral attitude.
inline constexpr double unconnected_opacity = 0.45;

/// Four digits; "none" if not finite.
std::string number_text(double value);

}  // namespace vrda::rom
