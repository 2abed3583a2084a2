/// What pages and pictures of ranges of motion have in common: a map of each slice, its axes, colours and
/// outlines.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/rom_files.hpp"

namespace vrda::analysis {

/// Abscissa, ordinate and slices of the maps: driven rotations first.
struct MapAxes {
  std::size_t x = 0, y = 1, slice = 2;
};
MapAxes map_axes(const RomAxes& axes);

double deg_at(const RomAxes& axes, std::size_t axis, std::size_t k);
/// Lower edge of the rectangle of value `k`, degrees: half way to its neighbour; of n the upper edge of the
/// last.
double edge_deg(const RomAxes& axes, std::size_t axis, std::size_t k);

/// Name of a rotation for the joint's kind, degrees.
std::string rotation_title(const RomDocument& document, std::size_t axis);

/// Four digits; "none" if not finite.
std::string number_text(double value);

using CellChoice = std::function<bool(std::size_t cell)>;

/// A boundary curve: between the cells that count and their neighbours that do not.
struct Outline {
  CellChoice counts;
  std::string colour;
};

/// A line of a map, degrees along its abscissa and its ordinate.
using MapLine = std::array<double, 4>;
std::vector<MapLine> outline_of(const RomAxes& axes, const MapAxes& map, std::size_t slice,
                                const CellChoice& counts);

/// The maps of one page or picture. Colours are "#rrggbb".
struct RomMaps {
  std::string title;
  const RomDocument& document;  ///< of which the axes and their names are
  std::function<std::string(std::size_t cell)> colour;
  std::vector<std::pair<std::string, std::string>> legend;  ///< colour and meaning
  std::vector<Outline> outlines = {};
};
/// The status of each cell, and the boundary of the range that is connected with the neutral attitude.
RomMaps status_maps(const RomDocument& document);
/// Which cells are in range of both, of one, of neither.
RomMaps comparison_maps(const RomDocument& a, const RomDocument& b);

/// An 8-bit RGB PNG.
std::string maps_picture(const RomMaps& maps);
/// An HTML page with `introduction` above the maps.
std::string maps_page(const RomMaps& maps, const std::string& introduction);

}  // namespace vrda::analysis
