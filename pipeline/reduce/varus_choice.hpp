/// Which varus lets both condyles bear, and between which columns of the grid it lies.
#pragma once

#include <limits>
#include <vector>

#include "motion/poses.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// The zero varus of one flexion. Columns are solved ones; both are the same where it falls on a column.
struct VarusChoice {
  ZeroVarusSource source = ZeroVarusSource::none;
  double varus_deg = std::numeric_limits<double>::quiet_NaN();
  double first_deg = std::numeric_limits<double>::quiet_NaN();  ///< of both_touch only, like last_deg
  double last_deg = std::numeric_limits<double>::quiet_NaN();
  Eigen::Index before = 0, after = 0;  ///< columns around it
  double share_after = 0.0;            ///< weight of `after` in a linear interpolation
};

/// [n_flexion]. Where varus was free: the one found. Else, where some solved columns touch with both
/// compartments: the mean of the first and last of them; columns between them that do not touch with both
/// part them into runs, of which the one nearest to the spine counts. Else the root, nearest to the spine, of
/// gap_medial - gap_lateral, linear between neighbouring solved columns. Else none.
/// `raw` is the motion of the model's raw surfaces.
/// Source: thesis 5.4, which knows one run only.
std::vector<VarusChoice> varus_choices(const MotionModel& model, const Motion& raw);

}  // namespace vrda
