/// Vertices of equal coordinates as one.
#pragma once

#include "load/raw_mesh.hpp"

namespace vrda {

struct WeldedVertices {
  std::vector<std::int32_t> of_raw;  ///< [n raw] row among the merged vertices
  Points vertices;                   ///< in the order in which the raw ones first give them
  Points normal_sums;                ///< empty when the file has none
};

/// Exactly equal: parsers repeat a shared vertex bit for bit, and a tolerance would close gaps the author
/// left.
WeldedVertices welded_vertices(const RawMesh& raw);

}  // namespace vrda
