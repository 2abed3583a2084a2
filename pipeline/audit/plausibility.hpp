/// Whether the stable poses of a motion model that was just solved are what their status says.
#pragma once

#include "ligament/ligaments.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// One entry a cell of the grid.
struct PoseVerdicts {
  GridB is_overlapping;  ///< 1 where the meshes of a stable pose overlap
  GridB plausibility;    ///< Plausibility; `not_judged` where not stable or overlapping
};

/// Measures every stable pose of the raw motion again (audit/pose_meter.hpp) and those a contact resolution
/// d away on either side: along X and Z of S and halfway between, turned about Delta through the moving
/// object's middle and, where varus was free, in varus; angles times half the object's larger horizontal
/// extent are d. A pose has nothing ahead where one of them has no touch within d along Delta. It is in
/// unstable balance where on both sides, moved on into contact, the energy of loads and ligaments is lower
/// than in the pose by more than what the push does over a thousandth of d. A pose that fibres hold without
/// contact is not held against either. `ligaments` are canonical. Same bits for any number of threads.
PoseVerdicts pose_verdicts(const MotionModel& model, const Ligaments& ligaments, int n_threads);

}  // namespace vrda
