/// What a reader should know before looking at any curve.
#pragma once

#include <string>
#include <vector>

#include "report/report.hpp"

namespace vrda {

/// Numbers of a motion model in short. NaN: not known, or not of this kind of model.
struct Numbers {
  std::int64_t n_cells = 0, n_stable = 0;
  double theta_undetermined_share = 0.0;   ///< of the stable cells
  double screw_home_range_deg = 0.0;       ///< largest less smallest internal rotation along the spine
  double largest_spine_jump_deg = 0.0;     ///< of theta between neighbouring flexions of the spine
  std::int64_t n_several_optima = 0;       ///< flexions; equilibrium only
  double largest_optima_spread_deg = 0.0;  ///< of theta among them
  double balance_residual_n = 0.0;         ///< largest
  double worst_gap_mm = 0.0;               ///< smallest
  double push_n = 0.0;                     ///< largest force of the push
  double largest_strain = 0.0;
  double largest_tension_n = 0.0;
};
Numbers numbers_of(const MotionModel& model);

/// One line each, worst first; empty when there is nothing to warn of.
std::vector<std::string> warnings_of(const ReportModel& entry);

}  // namespace vrda
