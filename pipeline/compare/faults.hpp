/// The worst of an audit: at the attitudes of the model's grid, and between them.
#pragma once

#include "store/motion_model.hpp"

namespace vrda {

/// NaN where no attitude counts.
struct Faults {
  int n_attitudes = 0;      ///< that count: all cells of the model around them are solved
  int n_overlapping = 0;    ///< of them
  int n_nothing_ahead = 0;  ///< of them: free, and no touch anywhere along Delta
  double largest_penetration_mm = 0.0;
  double largest_gap_mm = 0.0;  ///< of those free with a touch ahead
};

struct MotionFaults {
  Faults at_grid;  ///< attitudes of the model's grid
  Faults between;  ///< the others
};

/// Where a cell failed a smoothed motion has a pose without data: such attitudes do not count.
MotionFaults faults_of(const MotionModel& model, const AuditSet& audit);

}  // namespace vrda
