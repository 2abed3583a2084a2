/// Contact candidates of the kernel as features with a point and a normal.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/gap_kernel.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::geometry {

/// A candidate of a pair of triangles that may become a feature.
struct NearCandidate {
  TrianglePair pair;
  ContactCandidate at;
};

/// A vertex and a face, or two edges, of the reference and of the moving mesh.
struct FeatureKey {
  std::uint64_t of_reference, of_moving;
  bool operator==(const FeatureKey&) const = default;
};

/// A feature is found through each of its triangles: the first in the order of merge_features remains.
/// Overwrites `keys`, whose memory is reused.
void keep_one_candidate_per_feature(const Mesh& reference, const Mesh& moving,
                                    std::vector<NearCandidate>& near, std::vector<FeatureKey>& keys);

/// `reference` is directed down, `moving` up. The normal is the face's for a vertex on a face, the cross
/// product of the edges for two edges.
GapFeature gap_feature(const GapFace& reference, const GapFace& moving, const ContactCandidate& candidate,
                       const TrianglePair& pair, double offset_mm = 0.0);

/// Sorts by travel and removes duplicates found through several pairs of triangles (of equal travels the
/// smallest pair stays). Features at one point with different normals stay: each is a one-sided
/// linearisation.
void merge_features(std::vector<GapFeature>& features);

}  // namespace vrda::geometry
