/// Closed triangle meshes of smooth level sets.
#pragma once

#include <functional>

#include "core/mesh.hpp"

namespace vrda {

/// Negative inside, positive outside, in mm; about the signed distance near the surface. Its slope must stay
/// below LevelSetOptions::steepest_slope.
using Field = std::function<double(const Eigen::Vector3d&)>;

struct LevelSetOptions {
  double cell_mm = 2.0;         ///< edge of a sampling cell; mean triangle edges come out about as long
  double steepest_slope = 2.0;  ///< bound on |gradient|, used to skip empty space
  int n_relaxations = 12;       ///< passes that even out the triangles along the surface
};

/// The zero surface of `field` inside `box_mm` by surface nets, vertices moved onto the surface and evened
/// out along it; normals from the gradient. The surface must lie inside the box.
/// Closed and manifold: the cell is shrunk by a percent at a time until no edge is shared by more than two
/// faces. Cost: field evaluations near the surface only, about 25 a triangle.
Mesh level_set_mesh(const Field& field, const Box& box_mm, const LevelSetOptions& options);

struct LevelSet {
  Field field;
  Box box_mm;
};

/// The zero surface of `wanted`, which runs along that of `neighbour` for a while: where both fields agree to
/// the last bit it has the very triangles of level_set_mesh(neighbour), so that both look as one. Other
/// triangles follow on without a break. Closed and manifold; should the neighbour's cell not allow that, a
/// smaller one is taken, and the triangles only resemble the neighbour's.
Mesh level_set_mesh_along(const LevelSet& neighbour, const LevelSet& wanted, const LevelSetOptions& options);

}  // namespace vrda
