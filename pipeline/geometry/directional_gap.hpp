/// Directional gap: travel of the moving object along Delta (+Y of the solver frame) until contact.
#pragma once

#include <limits>

#include "geometry/placement.hpp"

namespace vrda::geometry {

/// A travel and the pair of triangles in contact at its end.
struct Gap {
  double travel_mm = std::numeric_limits<double>::infinity();  ///< infinite: no contact
  TrianglePair pair;                                           ///< -1, -1 without contact
};

/// Which travels count.
enum class GapKind {
  non_negative,   ///< the smallest non-negative one: the next contact along Delta from the current pose
  signed_facing,  ///< the smallest signed one over facing pairs: the first contact of an object approaching
                  ///< from far below; negative when the current pose is beyond it
};

struct GapOptions {
  GapKind kind = GapKind::non_negative;
  TrianglePair hint;  ///< a pair to evaluate first, usually the last result
};

/// Exact for triangle meshes: the smallest height difference of two triangles over the overlap of their
/// projections is at a vertex of one over a face of the other or where two projected edges cross.
/// `reference` is rotated to its attitude, `moving` a tree over (some of) the triangles of `moving_mesh`.
/// The hint affects the run time but not the result.
/// Offsets of the meshes (Mesh::offset_mm) round both surfaces: a pair touches where its distance is the sum.
/// With offsets a pair within that sum has the non-negative travel 0 until it has passed.
/// Faces whose unit normal has |n_y| < 1e-6 contribute only their edges. Ties: the smallest pair.
Gap directional_gap(const TreeMesh& reference, const Mesh& moving_mesh, const BoxTree& moving,
                    const MovingPose& pose, const GapOptions& options = {});

/// The travel of one pair of triangles, rounded by the sum of their offsets; infinite when they pass.
double pair_travel_mm(const Corners& reference, const Corners& moving, GapKind kind, double offset_mm = 0.0);

}  // namespace vrda::geometry
