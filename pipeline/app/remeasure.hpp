/// Gap and penetration at every attitude of a motion model, from its meshes and poses alone.
#pragma once

#include <vector>

#include "audit/audit.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// One entry a cell, flexion-major; as default for cells that are not stable.
std::vector<PoseAudit> remeasured(const MotionModel& model, int n_threads);

struct AuditExtremes {
  int n_overlapping = 0;
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;  ///< infinite when nothing is in the way of some cell
};

AuditExtremes extremes(const MotionModel& model, const std::vector<PoseAudit>& cells);

}  // namespace vrda
