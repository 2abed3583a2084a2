/// The printed bodies: geometry of their four markers, and the sheets to print. Lengths in mm.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/units.hpp"

namespace vrda::bench {

/// Two on each face.
inline constexpr std::size_t markers_a_body = 4;
/// Of the dictionary of 50 markers of 4 x 4 cells.
inline constexpr std::size_t most_bodies = 12;

/// A sheet glued around an edge, with two markers on each face. On a sheet of another size all lengths scale
/// with the marker.
struct BodySheet {
  double marker_mm = 40.0;               ///< measured on the print
  double fold_rad = rad_from_deg(90.0);  ///< angle between the faces, inside the body; pi: a flat sheet
};

/// White around each marker, mm for a marker of 40: more than the one cell that detection needs.
inline constexpr double sheet_margin_mm = 8.0;

/// Corners of a marker from its upper left one, clockwise as seen from outside.
using MarkerCorners = std::array<Eigen::Vector3d, 4>;

/// Markers of a body in its frame: origin in the middle of the edge, y along it towards the sheet's top, z
/// outwards between the faces, x to the right as seen from outside. Order: upper left, upper right, lower
/// left, lower right.
std::array<MarkerCorners, markers_a_body> marker_corners_mm(const BodySheet& sheet);

/// The cells of marker `id`, with its black border, from the upper left: true is black.
std::array<std::array<bool, 6>, 6> marker_cells(std::size_t id);

/// The board for the camera's calibration: squares of 38 mm on A4.
inline constexpr int board_columns = 7, board_rows = 5;
inline constexpr double board_square_mm = 38.0, board_marker_mm = 28.0;

/// A PDF file on A4: two bodies a page, then the board; names, sizes and the lines to cut and fold.
std::string sheets_pdf(const std::vector<std::string>& bodies);

}  // namespace vrda::bench
