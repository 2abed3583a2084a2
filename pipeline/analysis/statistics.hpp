/// How far a found quantity is from a measured one, and the scores of a constant and a straight
/// line.
#pragma once

#include <cstddef>
#include <vector>

#include "core/units.hpp"

namespace vrda::analysis {

/// Of d = found - measured over n frames, in the unit of the quantity; all but n are NaN without frames.
struct Statistics {
  std::size_t n = 0;
  double rms = nan;
  double bias = nan;           ///< mean of d
  double shape = nan;          ///< RMS of d - bias: rms^2 = bias^2 + shape^2
  double correlation = nan;    ///< Pearson's, of found and measured; NaN where one of them is constant
  double largest = nan;        ///< absolute value of d
  std::size_t largest_at = 0;  ///< the first frame that has it
};

/// `found` and `measured` have the same length.
Statistics statistics(const std::vector<double>& found, const std::vector<double>& measured);

/// value = mean + slope (x - mean_x).
struct Line {
  double mean_x = 0.0, mean = 0.0, slope = 0.0;
  double at(double x) const { return mean + slope * (x - mean_x); }
};

/// The mean of `values`, which are not empty.
Line constant(const std::vector<double>& values);

/// The least-squares line of `values` over `x`, of the same length; the constant where all x are equal.
Line straight_line(const std::vector<double>& x, const std::vector<double>& values);

/// RMS of the line's values minus the values; NaN without values.
double rms_of(const Line& line, const std::vector<double>& x, const std::vector<double>& values);

}  // namespace vrda::analysis
