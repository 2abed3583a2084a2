/// Checks of mesh files before they are parsed by assimp, which accepts truncated files and is unsafe with
/// damaged ones. All throw InputError naming file and line.
#pragma once

#include <string>

namespace vrda::load {

/// Binary STL: must have 84 + 50 n bytes; returned unchanged. ASCII STL: every facet must have three vertices
/// of three numbers, with endsolid at the end; returned with lower-case keywords and without names and
/// normals.
std::string checked_stl(const std::string& file, std::string bytes);

/// Wavefront OBJ: known keywords, valid numbers, indices of existing vertices. Returns only the v, vn and f
/// lines, with absolute indices. The format has no counts: truncation after a line is not detectable.
std::string checked_wavefront(const std::string& file, const std::string& bytes);

}  // namespace vrda::load
