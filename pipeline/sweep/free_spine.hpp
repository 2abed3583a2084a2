/// One flexion of a spine along which varus is left free: which of its places of rest counts.
#pragma once

#include <vector>

#include "core/step_record.hpp"

namespace vrda {

/// Starts aside from the lower of the two chains' ends, each added to pose and varus.
struct SpineOffset {
  double theta_rad = 0.0;
  double along_x_mm = 0.0;
  double along_z_mm = 0.0;
};

/// The first `n` (at most 8) of a fixed list that alternates turns and shifts, the small ones first.
std::vector<SpineOffset> spine_offsets(int n);

/// What the starts of one flexion led to.
struct FreeSpineStep {
  StepRecord chosen;               ///< the lowest energy; where none is stable, the first start's
  std::int32_t n_optima = 0;       ///< stable poses that differ by more than 0.1 mm or 0.1 degrees
  double theta_spread_rad = 0.0;   ///< largest less smallest theta of them
  double energy_spread_nmm = 0.0;  ///< largest less smallest energy of them
  StepRecord band_low;             ///< under the extra moment against theta; `pending` without a band
  StepRecord band_high;            ///< and with it
};

/// Whether two flexions' poses are neighbours of one course: within 1 mm and 1 degree in theta and varus.
bool is_near(const StepRecord& a, const StepRecord& b);

/// `ends` in the order of their starts: of equal energies (within 1e-6 N mm) the earlier counts.
FreeSpineStep lowest_of(const std::vector<StepRecord>& ends);

}  // namespace vrda
