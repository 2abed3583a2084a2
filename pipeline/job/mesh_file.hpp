/// Polygons of a mesh file: native axes and unit, not welded; only sizes and indices are checked.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::job {

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

/// PLY, ASCII or binary of either byte order. assimp is not used because it hangs on some valid files (lists
/// of texture coordinates) and reduces doubles to floats. Reads vertices with x, y, z (and normals nx, ny,
/// nz), faces with a list of vertex indices, and strips of triangles (tristrips). Other data named in the
/// header must be complete and is skipped, unless it has vertex indices. Throws InputError naming file and
/// line or element.
RawMesh read_ply(const std::string& file, const std::string& bytes);

/// A word of a file for messages: in quotation marks, cut at 40 characters.
std::string quoted_word(std::string_view word);

// Checks before assimp parses, which accepts truncated files and is unsafe with damaged ones. Both throw
// InputError naming file and line.
/// Binary STL: must have 84 + 50 n bytes; returned unchanged. ASCII STL: every facet must have three vertices
/// of three numbers, with endsolid at the end; returned with lower-case keywords and without names and
/// normals.
std::string checked_stl(const std::string& file, std::string bytes);

/// Wavefront OBJ: known keywords, valid numbers, indices of existing vertices. Returns only the v, vn and f
/// lines, with absolute indices. The format has no counts: truncation after a line is not detectable.
std::string checked_wavefront(const std::string& file, const std::string& bytes);

// Parser for Vertices-Faces (thesis 4.1): two counts, the vertices, then each face as its number of corners
// and their indices. Words are separated by white space; # starts a comment.

/// Whether the first word is a number, which distinguishes the format from Wavefront.
bool is_vertices_faces(const std::string& bytes);

/// Indices start at 0 if index 0 occurs, at 1 if the vertex count occurs as an index, and at 0 if neither
/// occurs. Throws InputError naming file and line.
RawMesh read_vertices_faces(const std::string& file, const std::string& bytes);

/// The normals file of a Vertices-Faces file (schemas/legacy-formats.md): their number, then one normal for
/// each vertex. Throws InputError naming file and line.
Points read_vertex_normals(const std::string& file, const std::string& bytes, Eigen::Index n_vertices);

}  // namespace vrda::job
