/// Closed meshes of flat-backed blocks and ellipsoids with analytically placed vertices.
#pragma once

#include <functional>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::geometry {

/// `n_steps` equal steps from `from` to `to`, both ends included, appended to `lines` (a common end once).
void append_lines(std::vector<double>& lines, double from, double to, int n_steps);

/// A block over a rectangle of the plane y = 0: a shaped front, a flat back, vertical walls.
struct ShapedBlock {
  std::vector<double> x_mm;                          ///< grid lines, increasing
  std::vector<double> z_mm;                          ///< grid lines, increasing
  std::function<double(double, double)> front_y_mm;  ///< over (x, z)
  double back_y_mm = 0.0;                            ///< above the whole front, or below it
  double hole_half_mm = 0.0;  ///< cells wholly within this distance of both axes are omitted
};

/// Mesh of a block. Cells of the front are split along the diagonal that follows a crease through the cell,
/// so that pyramids over matching grid lines are exact. Normals from the faces.
Mesh block_mesh(const ShapedBlock& block);

/// A four-sided pyramid with its tip at the origin, its base's edge at y = `rim_y_mm`, vertical walls and a
/// flat back at `back_y_mm`, below the rim for a pyramid or above the tip for a cavity. One triangle a slope.
Mesh plain_pyramid_mesh(double half_base_mm, double rim_y_mm, double back_y_mm);

/// An ellipsoid about the origin: 20 n^2 triangles of a subdivided icosahedron with a corner at the top, all
/// vertices on the ellipsoid.
Mesh ellipsoid_mesh(const Eigen::Vector3d& half_axes_mm, int n_edges);

}  // namespace vrda::geometry
