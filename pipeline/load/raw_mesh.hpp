/// Polygons as a file holds them: native axes and unit, nothing welded, nothing checked but sizes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

struct RawMesh {
  Points vertices;                   ///< [n, 3] native unit
  Points normals;                    ///< [n, 3] as the file gives them, or empty
  std::vector<std::int32_t> corner;  ///< rows of `vertices`, face after face
  std::vector<std::int32_t> size;    ///< [n_faces] corners of each face
};

inline constexpr std::size_t largest_mesh_bytes = std::size_t{512}
                                                  << 20U;  ///< ten times a million-triangle STL
/// A thousand kilometres in mm: volumes and squares of areas stay far within the range of doubles.
inline constexpr double largest_coordinate = 1e9;
inline constexpr std::size_t largest_face_count = 5'000'000;
inline constexpr std::size_t largest_face_size =
    1000;  ///< corners of one polygon: splitting costs their cube

/// Reads a mesh file's bytes: STL, PLY, Wavefront OBJ (by extension and content), or the Vertices-Faces
/// format of thesis 4.1: .vf, or .obj as the thesis has it, told from Wavefront by its first word, a number.
/// Throws InputError naming `file` and the place: wrong extension, cut short, counts that lie, a vertex
/// that is not finite or too far out, an index out of range, no faces.
RawMesh read_mesh(const std::string& file, std::string bytes);

}  // namespace vrda
