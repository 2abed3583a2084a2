/// Merges vertices with equal coordinates.
#pragma once

#include "load/raw_mesh.hpp"

namespace vrda::load {

struct WeldedVertices {
  std::vector<std::int32_t> index_of_raw;  ///< [n raw] index of the merged vertex
  Points vertices;                         ///< in the order of first occurrence
  Points normal_sums;                      ///< empty if the file has no normals
};

/// Coordinates must be exactly equal: parsers repeat a shared vertex bit for bit, and a tolerance would close
/// intended gaps.
WeldedVertices weld_vertices(const RawMesh& raw);

}  // namespace vrda::load
