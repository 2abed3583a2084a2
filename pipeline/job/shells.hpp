/// Connected components of a mesh and their orientation.
#pragma once

#include <vector>

#include "model/mesh.hpp"

namespace vrda::job {

/// A set of triangles connected by shared edges.
struct Shell {
  std::vector<Eigen::Index> triangles;  ///< ascending
  bool is_closed = true;                ///< every edge has two faces with consistent winding
  bool has_inside = true;      ///< closed, or closed but for some holes and odd faces; false: an open sheet
  double signed_volume = 0.0;  ///< cube of the mesh's unit; meaningful with an inside
  Box box;                     ///< in the mesh's unit
};

/// Shells, ordered by their first triangles.
std::vector<Shell> shells_of(const Mesh& mesh);

/// For each shell the outermost shell with an inside that encloses it; itself if none does. An enclosed shell
/// cannot be reached from outside, whatever its winding: an inner wall, or a void of a segmentation.
/// Only the 100 largest shells are considered as enclosing ones.
std::vector<std::size_t> outermost_shells(const Mesh& mesh, const std::vector<Shell>& shells);

/// Lists of triangles of the shells of at most a fifth of the largest one's size that are not enclosed.
std::vector<std::vector<Eigen::Index>> small_shells(const std::vector<Shell>& shells,
                                                    const std::vector<std::size_t>& outermost);

/// The mesh without enclosed shells and their vertices; unchanged without any. For what depends on the
/// outer shape alone: registration and thickness. Cost: a sort of the edges.
Mesh outer_surface(const Mesh& mesh);

/// The mesh with the listed triangles only, without unused vertices; the order of the others stays.
Mesh compacted(const Mesh& mesh, const std::vector<Eigen::Index>& kept);

/// The triangles of `mesh` that are in none of the `lists`.
std::vector<Eigen::Index> others_than(const Mesh& mesh, const std::vector<std::vector<Eigen::Index>>& lists);

}  // namespace vrda::job
