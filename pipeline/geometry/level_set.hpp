/// Blending of level-set fields (negative inside, about the signed distance in mm).
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "model/mesh.hpp"

namespace vrda::geometry {

/// Union with a fillet: the smaller value where the two differ by more than `width_mm`, and at most
/// width_mm / 6 below it where they are equal. Twice continuously differentiable.
inline double smooth_min(double a, double b, double width_mm)
{
  const double h = std::max(width_mm - std::abs(a - b), 0.0) / width_mm;
  return std::min(a, b) - h * h * h * width_mm / 6.0;
}

/// Intersection with a rounded edge: -smooth_min(-a, -b).
inline double smooth_max(double a, double b, double width_mm)
{
  return -smooth_min(-a, -b, width_mm);
}

/// 0 below `from`, 1 above `to`, quintic between: twice continuously differentiable.
inline double smooth_step(double from, double to, double x)
{
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

/// Negative inside, positive outside, in mm; about the signed distance near the surface. |gradient| must be
/// below LevelSetOptions::max_gradient.
using Field = std::function<double(const Eigen::Vector3d&)>;

struct LevelSetOptions {
  double cell_mm = 2.0;       ///< edge of a sampling cell, about the mean edge of the triangles
  double max_gradient = 2.0;  ///< bound on |gradient|, used to skip empty space
  int n_relaxations = 12;     ///< smoothing passes along the surface
};

/// The zero surface of `field` inside `box_mm` by surface nets; vertices are projected onto the surface and
/// relaxed along it; normals from the gradient. The surface must be inside the box. Closed and manifold: the
/// cell is reduced by one percent until no edge is shared by more than two faces. Cost: field evaluations
/// near the surface only, about 25 per triangle.
Mesh level_set_mesh(const Field& field, const Box& box_mm, const LevelSetOptions& options);

struct LevelSet {
  Field field;
  Box box_mm;
};

struct AdjoiningMeshes {
  Mesh first, second;
};

/// level_set_mesh() of `first`, and the zero surface of `second`, which partly coincides with it: where both
/// fields are bitwise equal both meshes have the same triangles, so that no seam is visible. Closed and
/// manifold; if the cell of the first does not give a manifold second mesh, a smaller cell is used and the
/// triangles differ slightly.
AdjoiningMeshes adjoining_level_set_meshes(const LevelSet& first, const LevelSet& second,
                                           const LevelSetOptions& options);

}  // namespace vrda::geometry
