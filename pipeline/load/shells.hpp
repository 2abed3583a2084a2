/// Connected components of a mesh and their orientation.
#pragma once

#include <vector>

#include "core/mesh.hpp"

namespace vrda::load {

/// A set of triangles connected by shared edges.
struct Shell {
  std::vector<Eigen::Index> triangles;  ///< ascending
  bool is_closed = true;                ///< every edge has two faces with consistent winding
  double signed_volume = 0.0;           ///< cube of the mesh's unit; meaningful when closed
  Box box;                              ///< in the mesh's unit
};

/// Shells, ordered by their first triangles.
std::vector<Shell> shells_of(const Mesh& mesh);

/// For each shell whether it must be reversed to point outward: an outermost closed shell if its volume is
/// negative, a nested closed shell together with its outermost enclosing shell, an open shell never.
std::vector<bool> inward_shells(const Mesh& mesh, const std::vector<Shell>& shells);

}  // namespace vrda::load
