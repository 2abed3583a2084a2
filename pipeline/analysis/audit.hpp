/// Gap and penetration of a motion at and between the attitudes of its model; travel of smoothed motions into
/// contact.
#pragma once

#include <string>

#include "core/units.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Measures the motion `set` (one of set_names of motion/poses.hpp) at the attitudes of the model's grid,
/// with each cell subdivided into `refine` (at least 1) parts per axis; for "two_sided", on its own axis, and
/// "zero_varus" only along flexion.
/// A sequence of frames is measured over its key.
/// Poses: the stored X_reference_moving for "raw" at the model's own attitudes, otherwise from Motion. At the
/// model's own attitudes the narrow phase tests every pose, between them the sweep if possible
/// (audit/pose_meter.hpp). Same bits for any number of threads.
store::AuditSet audit(const store::MotionModel& model, const std::string& set, int refine, int n_threads);

/// An extreme value of an audit and its attitude.
struct AuditExtreme {
  double value_mm = 0.0;  ///< 0 (attitude meaningless) without any
  double flexion_deg = 0.0, varus_deg = 0.0;
  double key = nan;  ///< of a sequence of frames
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

/// How far the moving object goes from one frame of a sequence to the next; frames without a pose are
/// omitted.
struct FrameTravel {
  int n_steps = 0;
  double largest_mm = 0.0,
         mean_mm = 0.0;  ///< of the moving point that is at the rotation centre in the zero pose
  double largest_rad = 0.0, mean_rad = 0.0;  ///< about the helical axis
  double key_of_mm = nan, key_of_rad = nan;  ///< at which the largest steps end
};
FrameTravel frame_travel(const store::MotionModel& model);

/// Travel along Delta (mm, negative: retreat) from the smoothed pose of `set` into contact at every attitude
/// of the model's grid, also without a raw pose, since polynomials are defined everywhere. A free pose
/// advances to the next contact. An overlapping pose retreats by 0.1, 0.2, 0.4 mm ... until free and advances
/// from there. Stops contact_margin_mm before contact, so that nothing overlaps. NaN without a contact ahead.
/// Same bits for any number of threads. `set` need not belong to the model; its recontact_mm is ignored.
store::GridD recontact(const store::MotionModel& model, const store::SmoothedSet& set, int n_threads);

}  // namespace vrda::analysis
