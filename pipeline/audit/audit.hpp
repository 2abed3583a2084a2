/// Gap and penetration of a whole motion, at the attitudes of its model and between them; poses that are not
/// what their status says; smoothed motions brought back into contact.
#pragma once

#include <string>

#include "ligament/ligaments.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Measures the motion `set` (one of set_names of motion/poses.hpp) at the attitudes of the model's grid,
/// each cell cut into `refine` (at least 1) parts along each axis; of "zero_varus" only flexion is cut.
/// Poses: of "raw" at the model's own attitudes X_reference_moving as it is stored, all others what Motion
/// answers. At the model's own attitudes the narrow phase judges every pose, between them the sweep where it
/// can (audit/pose_meter.hpp). Same bits for any number of threads.
AuditSet audit(const MotionModel& model, const std::string& set, int refine, int n_threads);

/// One number of an audit and where it stands.
struct AuditExtreme {
  double value_mm = 0.0;  ///< 0, at no attitude, where there is none
  double flexion_deg = 0.0, varus_deg = 0.0;
};

struct AuditFigures {
  int n_poses = 0;
  int n_overlapping = 0;
  int n_nothing_ahead = 0;
  AuditExtreme largest_penetration;
  AuditExtreme largest_gap;          ///< of the free poses with something ahead
  double mean_gap_mm = 0.0;          ///< of the same
  double mean_penetration_mm = 0.0;  ///< of the overlapping ones
};

AuditFigures figures_of(const AuditSet& audit);

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

/// Travel along Delta (mm, negative: back) from the smoothed pose of `set` into contact, at each attitude of
/// the model's grid: at all of them, also where no raw pose was found, since polynomials have a pose
/// everywhere. Rule: the contact that the pose itself would meet if it were let go. Free: on to the next
/// touch. Overlapping: back by 0.1, 0.2, 0.4 mm ... until free, on from there to the next touch. Stops
/// contact_margin_mm short of it, so that nothing overlaps. NaN where nothing is in the way. Same bits for
/// any number of threads. `set` need not be one of the model's, and what it holds of recontact_mm plays no
/// part.
GridD recontact(const MotionModel& model, const SmoothedSet& set, int n_threads);

}  // namespace vrda
