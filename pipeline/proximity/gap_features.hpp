/// Contact candidates of the kernel as features with a point and a normal.
#pragma once

#include "proximity/gap_kernel.hpp"
#include "proximity/gap_query.hpp"

namespace vrda::proximity {

/// `reference` is directed down, `moving` up. The normal is the face's for a vertex on a face, the cross
/// product of the edges for two edges.
GapFeature gap_feature(const GapFace& reference, const GapFace& moving, const ContactCandidate& candidate,
                       const TrianglePair& pair, double offset_mm = 0.0);

/// Sorts by travel and removes duplicates found through several pairs of triangles (of equal travels the
/// smallest pair stays). Features at one point with different normals stay: each is a one-sided
/// linearisation.
void merge_features(std::vector<GapFeature>& features);

}  // namespace vrda::proximity
