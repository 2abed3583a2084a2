/// What a mesh file promises against what it holds, before a parser sees it: parsers take files cut short
/// and lose their footing in damaged ones. All throw InputError naming file and place.
#pragma once

#include <string>

namespace vrda {

/// Binary STL: exactly 84 + 50 n bytes, returned as they are. ASCII STL: every facet with three vertices of
/// three numbers, endsolid at the end; returned with lower-case keywords and without names and normals.
std::string checked_stl(const std::string& file, std::string bytes);

/// Wavefront OBJ: known keywords, numbers where numbers belong, indices of vertices that are there. Returns
/// the file reduced to what a mesh is made of, v, vn and f lines with absolute indices. The format has no
/// counts: a file cut at the end of a line cannot be told from a whole one.
std::string checked_wavefront(const std::string& file, const std::string& bytes);

}  // namespace vrda
