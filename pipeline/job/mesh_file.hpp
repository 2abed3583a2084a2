/// Polygons of a mesh file: native axes and unit, not welded; only sizes and indices are checked.
#pragma once

#include <cstdint>
#include <span>
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
  std::vector<std::string> notes;    ///< what of the file was ignored, as sentences for warnings
};

inline constexpr std::size_t largest_mesh_bytes = std::size_t{512}
                                                  << 20U;  ///< ten times a million-triangle STL
/// 1000 km in mm: volumes and squared areas stay within the range of doubles.
inline constexpr double largest_coordinate = 1e9;
inline constexpr std::size_t largest_face_count = 5'000'000;
inline constexpr std::size_t largest_face_size =
    1000;  ///< corners of one polygon: triangulation is cubic in it

/// Parses the bytes of a mesh file by extension and content: STL, PLY, Wavefront OBJ, VTK PolyData, or
/// Vertices-Faces (thesis 4.1) as .vf or as .obj whose first word is a number. Text may begin with a byte
/// order mark of UTF-8 and have any line ends. Throws InputError naming `file` and the position for: wrong
/// extension, truncation, wrong counts, a vertex that is not finite or too large, an index out of range, no
/// faces; naming the content instead where that is another kind of file (FileContent).
RawMesh read_mesh(const std::string& file, std::string bytes);

/// PLY, ASCII or binary of either byte order. assimp is not used because it hangs on some valid files (lists
/// of texture coordinates) and reduces doubles to floats. Reads vertices with x, y, z (and normals nx, ny,
/// nz), faces with a list of vertex indices, and strips of triangles (tristrips). Other data named in the
/// header must be complete and is skipped, unless it has vertex indices. Throws InputError naming file and
/// line or element.
RawMesh read_ply(const std::string& file, const std::string& bytes);

/// VTK PolyData as XML (.vtp): arrays as text, base64 or appended (raw or base64), plain or compressed by
/// zlib, of either byte order. Reads points, polygons and strips of triangles of all pieces; other arrays are
/// skipped. Throws InputError naming file and element, or line.
RawMesh read_vtp(const std::string& file, const std::string& bytes);

/// VTK PolyData in the legacy format (.vtk), versions 1 to 5, ASCII or binary. Reads points, polygons and
/// strips of triangles. Throws InputError naming file and section, or line.
RawMesh read_legacy_vtk(const std::string& file, const std::string& bytes);

/// Adds a polygon; lines and points (fewer than three corners) are left out.
void add_face(RawMesh& mesh, std::span<const std::int32_t> corners);
/// Adds the triangles of strips: a negative index ends a strip.
void add_strips(RawMesh& mesh, std::span<const std::int32_t> corners);

/// What a file is by its first bytes.
struct FileContent {
  std::string name;       ///< "an STL file", "an HTML page"; empty: unknown
  std::string extension;  ///< of a format that read_mesh() reads; else empty
  std::string remedy;     ///< how to get a file that is read
};
/// Formats of meshes, images and documents, compressed data, pointers to large files, UTF-16.
FileContent content_of(std::string_view bytes);
/// Throws InputError for a table that is other content (content_of), such as UTF-16 or an HTML page.
void require_table(const std::string& file, std::string_view bytes);

/// Removes a byte order mark and the last character 1A of a DOS text, and writes line ends that are only
/// carriage returns as line feeds. Binary data stay unchanged: that of PLY after its header, of VTK, and of
/// STL.
void normalise_text(std::string& bytes);

/// A word of a file for messages: in quotation marks, cut at 40 characters.
std::string quoted_word(std::string_view word);

// Checks before assimp parses, which accepts truncated files and is unsafe with damaged ones. Both throw
// InputError naming file and line.
struct CheckedText {
  std::string bytes;
  std::vector<std::string> notes;  ///< what is ignored
};
/// Binary STL: must have 84 + 50 n bytes; more are ignored with a note unless they are facets; returned
/// unchanged. ASCII STL: every facet must have three vertices of three numbers, with endsolid (or "end
/// solid") at the end; returned with lower-case keywords and without names and normals, which are not used.
CheckedText checked_stl(const std::string& file, const std::string& bytes);
/// Whether the size is that of the header's number of triangles, above 0.
bool is_binary_stl(std::string_view bytes);
/// Whether the file begins with "solid" and is text: binary headers may also begin with "solid".
bool is_ascii_stl(std::string_view bytes);

/// Wavefront OBJ: known keywords, valid numbers, indices of existing vertices. Returns only the v, vn and f
/// lines, with absolute indices. The format has no counts: truncation after a line is not detectable.
CheckedText checked_wavefront(const std::string& file, const std::string& bytes);

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
