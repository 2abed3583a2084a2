/// Requirements on a measured motion, and the gap limit that follows from it.
#pragma once

#include <vector>

#include "analysis/repair.hpp"

namespace vrda::analysis {

/// Throws InputError as repair() says.
void require_repairable(const MeasuredMotion& measured, const RepairOptions& options);

/// A gap along Delta and its standard deviation by the noise of the pose.
struct MeasuredGap {
  double mm = 0.0;
  double noise_mm = 0.0;
};

/// The limit of GapLimit::from_measurement from the gaps of successive frames; infinite without gaps. The
/// noise of the gaps is what the poses' noise gives, or less if their second differences show less.
double supported_gap_mm(const std::vector<MeasuredGap>& gaps);

}  // namespace vrda::analysis
