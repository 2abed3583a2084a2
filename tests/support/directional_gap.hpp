/// An oracle of the directional gap: refitted boxes in double, without the bounds, planes and vector code of
/// geometry::GapQuery. Travel of the moving object along Delta (+Y of the solver frame) until contact.
#pragma once

#include "geometry/gap_query.hpp"
#include "geometry/placement.hpp"

namespace vrda::test {

/// Exact for triangle meshes: the smallest height difference of two triangles over the overlap of their
/// projections is at a vertex of one over a face of the other or where two projected edges cross.
/// `reference` is rotated to its attitude, `moving` a tree over (some of) the triangles of `moving_mesh`.
/// Offsets of the meshes (Mesh::offset_mm) round both surfaces: a pair touches where its distance is the sum.
/// With offsets a pair within that sum has the non-negative travel 0 until it has passed.
/// Faces whose unit normal has |n_y| < 1e-6 contribute only their edges. Ties: the smallest pair.
geometry::Gap directional_gap(const geometry::TreeMesh& reference, const Mesh& moving_mesh,
                              const geometry::BoxTree& moving, const MovingPose& pose,
                              geometry::GapKind kind = geometry::GapKind::non_negative);

/// The travel of one pair of triangles, rounded by the sum of their offsets; infinite when they pass.
double pair_travel_mm(const geometry::Corners& reference, const geometry::Corners& moving,
                      geometry::GapKind kind, double offset_mm = 0.0);

}  // namespace vrda::test
