/// How far one point can travel before it meets a mesh.
#pragma once

#include "core/mesh.hpp"
#include "proximity/box_tree.hpp"

namespace vrda {

struct Ray {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< unit
  double longest_mm = 0.0;
};

/// Travel to the first triangle of `mesh` that faces the ray (its normal against the direction), infinite
/// where none is within the longest. Everything in the mesh's own frame, any direction. A ray through an edge
/// or a vertex meets a triangle there. Allocates nothing; under a microsecond for short rays.
/// Source: Moeller and Trumbore (1997), J Graphics Tools 2(1):21-28.
double ray_travel_mm(const Mesh& mesh, const BoxTree& tree, const Ray& ray);

}  // namespace vrda
