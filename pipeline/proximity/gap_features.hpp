/// Meeting places of the kernel as features with a point and a normal.
#pragma once

#include "proximity/gap_kernel.hpp"
#include "proximity/gap_query.hpp"

namespace vrda {

/// `reference` looks down, `moving` looks up. The normal is the face's where a vertex meets it, across both
/// edges where two meet.
GapFeature gap_feature(const GapFace& reference, const GapFace& moving, const MeetingPlace& place,
                       const TrianglePair& pair);

/// Nearest first, the same place seen from several pairs of triangles once (of the smallest pair among equal
/// travels). Places at one point with different normals all stay: each is a one-sided linearisation there.
void merge_features(std::vector<GapFeature>& features);

}  // namespace vrda
