/// What a mesh file promises against what it holds, before a parser sees it: parsers accept files cut short.
#pragma once

#include <string>

namespace vrda {

/// Binary STL: exactly 84 + 50 n bytes. ASCII STL: every facet with three vertices, endsolid at the end.
/// Throws InputError naming file and place.
void check_stl_size(const std::string& file, const std::string& bytes);

/// PLY: every element of the header is there in full, ASCII or binary.
/// Throws InputError naming file and place.
void check_ply_size(const std::string& file, const std::string& bytes);

}  // namespace vrda
