/// Small generated meshes, normals outward.
#pragma once

#include "model/mesh.hpp"

namespace vrda::test {

/// Axis-aligned box, 12 triangles.
Mesh box(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& size_mm);

/// Sphere of latitude rings; all vertices on the sphere, poles on +-Y.
Mesh ball(double radius_mm, int n_rings = 16, int n_sectors = 32);

/// Flat open sheet in the plane y = 0, n x n quads, normal +Y.
Mesh sheet(double size_mm, int n);

/// Square of two triangles in the plane y = 0 about the origin, normal +Y or -Y.
Mesh plate(double half_width_mm, bool is_up);

}  // namespace vrda::test
