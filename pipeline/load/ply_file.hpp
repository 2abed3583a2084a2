/// Parser for PLY: ASCII or binary of either byte order. assimp is not used because it hangs on some valid
/// files (lists of texture coordinates) and reduces doubles to floats.
#pragma once

#include <string>

#include "load/raw_mesh.hpp"

namespace vrda::load {

/// Reads vertices with x, y, z (and normals nx, ny, nz) and faces with a list of vertex indices. Other data
/// named in the header must be complete and is skipped. Throws InputError naming file and line or element.
RawMesh read_ply(const std::string& file, const std::string& bytes);

}  // namespace vrda::load
