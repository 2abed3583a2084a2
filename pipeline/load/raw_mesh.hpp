/// Polygons of a mesh file: native axes and unit, not welded; only sizes and indices are checked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda::load {

struct RawMesh {
  Points vertices;                   ///< [n, 3] native unit
  Points normals;                    ///< [n, 3] as in the file, or empty
  std::vector<std::int32_t> corner;  ///< row indices into `vertices`, face by face
  std::vector<std::int32_t> size;    ///< [n_faces] number of corners of each face
};

inline constexpr std::size_t largest_mesh_bytes = std::size_t{512}
                                                  << 20U;  ///< ten times a million-triangle STL
/// 1000 km in mm: volumes and squared areas stay within the range of doubles.
inline constexpr double largest_coordinate = 1e9;
inline constexpr std::size_t largest_face_count = 5'000'000;
inline constexpr std::size_t largest_face_size =
    1000;  ///< corners of one polygon: triangulation is cubic in it

/// Parses the bytes of a mesh file by extension and content: STL, PLY, Wavefront OBJ, or Vertices-Faces
/// (thesis 4.1) as .vf or as .obj whose first word is a number. Throws InputError naming `file` and the
/// position for: wrong extension, truncation, wrong counts, a vertex that is not finite or too large, an
/// index out of range, no faces.
RawMesh read_mesh(const std::string& file, std::string bytes);

}  // namespace vrda::load
