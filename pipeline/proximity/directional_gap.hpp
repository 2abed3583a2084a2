/// How far the moving object can travel along Delta (+Y of the solver frame) before it touches.
#pragma once

#include <limits>

#include "proximity/placed.hpp"

namespace vrda {

/// A travel and the pair of triangles that ends it.
struct Gap {
  double travel_mm = std::numeric_limits<double>::infinity();  ///< infinite: nothing in the way
  TrianglePair pair;                                           ///< -1, -1 when nothing in the way
};

/// Which travels count.
enum class GapKind {
  from_here,  ///< the smallest non-negative one: the next touch on the way up
  from_afar,  ///< the smallest signed one over facing pairs: the first touch of an object that comes from
              ///< far below; negative when it stands deeper than that
};

struct GapOptions {
  GapKind kind = GapKind::from_here;
  TrianglePair hint;  ///< a pair worth trying first, usually the last answer
};

/// Exact for triangle meshes: the smallest height difference of two triangles over the overlap of their
/// projections lies at a vertex of one over a face of the other or where two projected edges cross.
/// `reference` is turned to its attitude, `moving` a tree over (some of) the triangles of `moving_mesh`.
/// The hint changes the time, never the answer.
/// Faces whose unit normal has |n_y| < 1e-6 take part by their edges only. Ties: the smallest pair.
/// Source: DESIGN.md 5.2.
Gap directional_gap(const TreeMesh& reference, const Mesh& moving_mesh, const BoxTree& moving,
                    const MovingPose& pose, const GapOptions& options = {});

/// The travel of one pair (its own minimum), infinite when their projections do not overlap.
double pair_travel_mm(const Corners& reference, const Corners& moving, GapKind kind);

}  // namespace vrda
