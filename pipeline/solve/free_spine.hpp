/// One flexion of a spine with free varus: solves it from several starts and selects one of its equilibria,
/// that of the lowest energy. Poses are in the solver frame S: mm, rad; energies in N mm. A flexion of which
/// no start is solved keeps the status of its first result.
#pragma once

#include <vector>

#include "model/step_record.hpp"

namespace vrda::solve {

/// Offset of a restart from the lower result of the two chains, added to its pose.
struct SpineOffset {
  double theta_rad = 0.0;
  double shift_x_mm = 0.0;
  double shift_z_mm = 0.0;
};

/// The first `n` (at most 8) of a fixed list of rotations and shifts, small ones first.
std::vector<SpineOffset> spine_offsets(int n);

/// Small offsets to either side, in theta, x and z, of two sizes.
std::vector<SpineOffset> polish_offsets();

/// One of the distinct equilibria of a flexion: no other one is within 0.1 mm and 0.1 degrees.
struct SpineEquilibrium {
  MovingPose pose;
  double varus_rad = 0.0;
  double energy_nmm = 0.0;
  bool is_chosen = false;
};

/// Results of all starts of one flexion.
struct FreeSpineStep {
  StepRecord chosen;                         ///< lowest energy; if none is stable, the first result
  std::int32_t n_optima = 0;                 ///< stable poses that differ by more than 0.1 mm or 0.1 degrees
  double theta_spread_rad = 0.0;             ///< largest minus smallest theta of them
  double energy_spread_nmm = 0.0;            ///< largest minus smallest energy of them
  std::vector<SpineEquilibrium> equilibria;  ///< [n_optima] in the order of their first starts
  StepRecord band_low;   ///< with the extra moment against theta; `pending` without a band
  StepRecord band_high;  ///< with the extra moment along theta
};

/// `ends` in the order of their starts: of equal energies (within 1e-6 N mm) the earlier is chosen.
FreeSpineStep select_lowest(const std::vector<StepRecord>& ends);

}  // namespace vrda::solve
