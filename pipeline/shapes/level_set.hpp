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

struct AdjoiningMeshes {
  Mesh first, second;
};

/// level_set_mesh() of `first`, and the zero surface of `second`, which runs along it for a while: where both
/// fields agree to the last bit the second has the very triangles of the first, so that both look as one.
/// Other triangles follow on without a break. Closed and manifold; should the first's cell not allow that for
/// the second, a smaller one is taken, and the triangles only resemble the first's.
AdjoiningMeshes adjoining_level_set_meshes(const LevelSet& first, const LevelSet& second,
                                           const LevelSetOptions& options);

}  // namespace vrda
