/// Recommends the lowest degree whose leave-one-out error is as good as the best one.
#pragma once

#include <string>
#include <vector>

#include "smooth/smooth.hpp"

namespace vrda::compare {

/// Leave-one-out errors of one degree, in units of the perceptible error.
struct DegreeErrors {
  int degree = 0;
  /// [n_cells] squared, the same cells in the same order for every degree; empty if a cell cannot be omitted.
  std::vector<double> leave_one_out_sq;
};

/// One degree compared with the best.
struct RankedDegree {
  int degree = 0;
  double error = 0.0;           ///< root mean square; NaN if a cell cannot be omitted, like the next two
  double excess_sq = 0.0;       ///< mean over the cells of squared error minus that of the best
  double standard_error = 0.0;  ///< of excess_sq, paired: from the spread of the differences per cell
  bool is_within = false;       ///< excess_sq <= 2 standard_error
};

struct Recommendation {
  int degree = -1;       ///< -1 if no degree can be ranked
  int best_degree = -1;  ///< degree with the smallest error
  std::string reason;    ///< one sentence
  std::vector<RankedDegree> ranked;
};

/// Recommends the lowest degree within two paired standard errors of the best (DESIGN.md 5.5). Errors of a
/// cell below 1e-6 count as 1e-6: they are rounding, and their order is chance. Expects ascending degrees.
Recommendation recommend(const std::vector<DegreeErrors>& degrees);

/// [n_fits] The error of each cell's pose, input of recommend(); compare/compare.hpp has the rules. Cells are
/// those fitted in translation. Robust if the fits are. `fits` are of one model by ascending degree.
std::vector<DegreeErrors> degree_errors(const std::vector<smooth::SmoothFit>& fits);

}  // namespace vrda::compare
