/// The thesis's stability search with every collision decided by FCL, as a reference for VRDA's queries.
/// Only for benchmarks; the product's search is solve/stability_search.hpp.
#pragma once

#include <fcl/geometry/bvh/BVH_model.h>

#include <memory>

#include "model/step_record.hpp"
#include "solve/sweep.hpp"

namespace vrda::benchmarks {

using FclModel = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<FclModel> fcl_model(const Mesh& mesh);

/// Both objects at zero attitude and pose, S. Shared by all threads.
struct FclPair {
  explicit FclPair(const solve::Joint& joint);
  std::shared_ptr<FclModel> reference;
  std::shared_ptr<FclModel> moving;
};

struct FclStep {
  StepRecord record;
  int n_collisions = 0;      ///< FCL queries; `record.queries` also counts contact and gap queries
  double collision_s = 0.0;  ///< processor time
};

/// Thesis 3.2 to 3.6: retreat while the seed overlaps; move along Delta in translation steps until blocked,
/// bisected to the resolution; rotate or translate as the contacts predict, in the product's sub-steps,
/// bisected likewise; a repeated pose halves the step that led there. Without the directional gap, so it
/// steps where the product measures, and without the product's additions (no check for an ascent direction,
/// no halving of translations that leave the reference), which cost queries. Contact points, the two
/// predictions, and at the final pose the quantities that the sweep needs to choose its spine (flags and gaps
/// of the compartments) are VRDA's.
FclStep find_stable_pose_by_fcl(const solve::Joint& joint, const FclPair& models, const Attitude& attitude,
                                const MovingPose& seed, const SearchOptions& options);

}  // namespace vrda::benchmarks
