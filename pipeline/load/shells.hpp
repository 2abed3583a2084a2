/// Connected pieces of a mesh and which way they face.
#pragma once

#include <vector>

#include "core/mesh.hpp"

namespace vrda {

/// Triangles connected over shared edges.
struct Shell {
  std::vector<Eigen::Index> triangles;  ///< ascending
  bool is_closed = true;                ///< every edge has two faces, wound consistently
  double signed_volume = 0.0;           ///< cube of the mesh's unit; meaningful when closed
  Box box;                              ///< in the mesh's unit
};

/// Shells in the order of their first triangles.
std::vector<Shell> shells_of(const Mesh& mesh);

/// For each shell whether it has to be reversed to point outward: an outermost closed shell by its volume,
/// a closed shell inside another along with the outermost around it, open shells never.
std::vector<bool> inward_shells(const Mesh& mesh, const std::vector<Shell>& shells);

}  // namespace vrda
