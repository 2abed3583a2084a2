/// Gap and penetration of a whole motion, at the attitudes of its model and between them.
#pragma once

#include <string>

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

}  // namespace vrda
