/// Gap and penetration of a motion at and between the attitudes of its model; plausibility of solved poses;
/// travel of smoothed motions into contact.
#pragma once

#include <string>

#include "ligament/ligaments.hpp"
#include "store/motion_model.hpp"

namespace vrda::audit {

/// Measures the motion `set` (one of set_names of motion/poses.hpp) at the attitudes of the model's grid,
/// with each cell subdivided into `refine` (at least 1) parts per axis; for "two_sided", on its own axis, and
/// "zero_varus" only along flexion.
/// Poses: the stored X_reference_moving for "raw" at the model's own attitudes, otherwise from Motion. At the
/// model's own attitudes the narrow phase tests every pose, between them the sweep if possible
/// (audit/pose_meter.hpp). Same bits for any number of threads.
store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine, int n_threads);

/// An extreme value of an audit and its attitude.
struct AuditExtreme {
  double value_mm = 0.0;  ///< 0 (attitude meaningless) without any
  double flexion_deg = 0.0, varus_deg = 0.0;
};

struct AuditFigures {
  int n_poses = 0;
  int n_overlapping = 0;
  int n_nothing_ahead = 0;
  AuditExtreme largest_penetration;
  AuditExtreme largest_gap;          ///< of the free poses with a contact ahead
  double mean_gap_mm = 0.0;          ///< of the same poses
  double mean_penetration_mm = 0.0;  ///< of the overlapping poses
  store::TwoSidedFigures two_sided;  ///< of all poses, if the joint has compartments
};

AuditFigures figures_of(const store::AuditSet& audit);

/// One entry per cell of the grid.
struct PoseAssessment {
  store::GridB is_overlapping;  ///< 1 if the meshes of a stable pose overlap
  store::GridB plausibility;    ///< Plausibility; `not_judged` if not stable or overlapping
};

/// Measures every stable pose of the raw motion again (audit/pose_meter.hpp), and its neighbours displaced by
/// a contact resolution d to both sides: along X and Z of S, their diagonals, rotation about Delta through
/// the moving object's centre and, if varus was free, varus; angles are d over half the object's larger
/// horizontal extent. nothing_ahead: one of them has no contact within d along Delta. unstable_balance: on
/// both sides, after moving into contact, the energy of loads and ligaments is lower than in the pose by more
/// than the work of the push over d / 1000. Poses held by fibres without contact are exempt from both.
/// `ligaments` are canonical. Same bits for any number of threads.
PoseAssessment assess_poses(const store::MotionModel& model, const ligament::Ligaments& ligaments,
                            int n_threads);

/// Travel along Delta (mm, negative: retreat) from the smoothed pose of `set` into contact at every attitude
/// of the model's grid, also without a raw pose, since polynomials are defined everywhere. A free pose
/// advances to the next contact. An overlapping pose retreats by 0.1, 0.2, 0.4 mm ... until free and advances
/// from there. Stops contact_margin_mm before contact, so that nothing overlaps. NaN without a contact ahead.
/// Same bits for any number of threads. `set` need not belong to the model; its recontact_mm is ignored.
store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, int n_threads);

}  // namespace vrda::audit
