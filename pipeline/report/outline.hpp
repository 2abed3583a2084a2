/// The rim of a body near the joint, seen along its long axis, to draw contact paths in.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

struct OutlineOptions {
  double from_mm = 0.0;  ///< heights (canonical Y) of the triangles that count, by their corners
  double to_mm = 0.0;
  int n_directions = 240;  ///< points of the outline
};

/// Closed star-shaped outline (X, Z, mm; canonical) of the mesh's projection on the plane across Y: in each
/// direction from the middle of its bounding box the farthest crossing with an edge. Empty when no triangle
/// counts; directions without a crossing are left out.
std::vector<Eigen::Vector2d> outline(const Mesh& mesh, const OutlineOptions& options);

}  // namespace vrda
