/// PLY, ASCII or binary of either byte order, read here: assimp's reader hangs on some valid files (lists of
/// texture coordinates) and keeps floats where the file has doubles.
#pragma once

#include <string>

#include "load/raw_mesh.hpp"

namespace vrda {

/// Vertices with x, y, z (and normals nx, ny, nz); faces with a list of vertex indices. Everything else that
/// the header announces has to be there in full and is passed over. Throws InputError naming file and place.
RawMesh read_ply(const std::string& file, const std::string& bytes);

}  // namespace vrda
