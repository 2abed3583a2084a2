/// The stability search of the thesis with every collision decided by FCL: what our own queries are measured
/// against. Written for that only; the product's search is solve/stability_search.hpp.
#pragma once

#include <fcl/geometry/bvh/BVH_model.h>

#include <memory>

#include "core/solver_options.hpp"
#include "core/step_record.hpp"
#include "solve/joint.hpp"

namespace vrda::bench {

using FclModel = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<FclModel> fcl_model(const Mesh& mesh);

/// Both objects at zero attitude and pose, S. Shared by all threads.
struct FclPair {
  explicit FclPair(const Joint& joint);
  std::shared_ptr<FclModel> reference;
  std::shared_ptr<FclModel> moving;
};

struct FclStep {
  StepRecord record;
  int n_collisions = 0;      ///< asked of FCL; `record.queries` counts contacts and gaps too
  double collision_s = 0.0;  ///< processor time
};

/// Thesis 3.2 to 3.6: retreat while the seed overlaps; up along Delta in translation steps until something is
/// in the way, bisected to the resolution; turn or slide as the contacts predict, in the product's sub-steps,
/// bisected likewise; a pose seen before halves the step that led there. Knows no directional gap, so it
/// steps where the product measures, and none of the product's additions (no check for a way up, no halving
/// of slides that leave the reference), which cost queries. Ours are the contact points, the two predictions,
/// and at the final pose what the sweep needs to choose its spine (flags and gaps of the compartments).
FclStep find_stable_pose_by_fcl(const Joint& joint, const FclPair& models, const Attitude& attitude,
                                const MovingPose& seed, const SearchOptions& options);

}  // namespace vrda::bench
