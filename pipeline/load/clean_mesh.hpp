/// From a file's polygons to a mesh the solver can use.
#pragma once

#include "load/job.hpp"
#include "load/raw_mesh.hpp"

namespace vrda {

struct CleanMesh {
  Mesh mesh;                      ///< in the raw mesh's axes and unit; with normals, all vertices in use
  Eigen::Index n_welded = 0;      ///< vertices merged with an earlier one
  Eigen::Index n_degenerate = 0;  ///< faces and triangles dropped: a repeated corner or no area
  bool was_flipped = false;       ///< the winding of at least one shell was reversed
};

/// Welds vertices of equal coordinates (exactly equal: parsers repeat a shared vertex bit for bit, and a
/// tolerance would close gaps the author left), triangulates, drops what is degenerate or unused.
/// Orientation, shell by shell (triangles connected over edges): a closed shell that lies in no other one is
/// turned outward by its signed volume; a closed shell inside another turns along with the outermost one
/// around it, so the inner wall of a hollow body stays an inner wall; an open shell follows `winding`.
/// Normals: the file's, averaged over merged vertices and turned to the outside, where every one has a
/// length; else computed.
/// Vertices are numbered by first use along the final winding, on a left joint against it: a mirrored file
/// with the other side gives the mirrored mesh to the last bit, with its winding reversed or not.
CleanMesh clean_mesh(const RawMesh& raw, Winding winding, Side side);

}  // namespace vrda
