/// Which degree to take: the lowest that predicts left-out cells as well as the best one does.
#pragma once

#include <string>
#include <vector>

#include "smooth/smooth.hpp"

namespace vrda {

/// One arc minute seen from 0.5 m (DESIGN.md 5.5): 500 mm * pi / 10800 = 0.1454 mm.
inline constexpr double perceptible_mm = 0.145;
/// The turn that moves a point 3 cm from the axis that far (DESIGN.md 5.5): 0.2778 degrees of 0.1454 mm.
inline constexpr double perceptible_deg = 0.27;

/// What one degree gets wrong at the cells left out. Errors are counted in units of what is perceptible.
struct DegreeErrors {
  int degree = 0;
  /// [n_cells] squared, the same cells in the same order for every degree; empty where some cell cannot be
  /// left out.
  std::vector<double> left_out_sq;
};

/// One degree against the best.
struct RankedDegree {
  int degree = 0;
  double error = 0.0;      ///< root mean square; NaN where some cell cannot be left out, like the next two
  double excess_sq = 0.0;  ///< mean over the cells of its squared error less the best one's
  double standard_error = 0.0;  ///< of excess_sq, paired: from the spread of the differences cell by cell
  bool is_within = false;       ///< excess_sq <= 2 standard_error
};

struct Recommendation {
  int degree = -1;       ///< -1 where no degree can be judged
  int best_degree = -1;  ///< of the smallest error
  std::string reason;    ///< one sentence
  std::vector<RankedDegree> ranked;
};

/// Recommends the lowest degree within two paired standard errors of the best (DESIGN.md 5.5). The error of a
/// cell counts as 1e-6 at least: below that a surface is met to rounding, and who is better is chance.
/// Expects rising degrees.
Recommendation recommend(const std::vector<DegreeErrors>& degrees);

/// [n_fits] For recommend(): the error of each cell's pose, rules in compare/compare.hpp. Cells are those
/// fitted in translation. Robust where the fits are. `fits` are of one model by rising degree.
std::vector<DegreeErrors> degree_errors(const std::vector<SmoothFit>& fits);

}  // namespace vrda
