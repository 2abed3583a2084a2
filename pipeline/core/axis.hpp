/// Where a value is on an axis of ascending numbers, for tables over flexion, keys and probabilities.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vrda::inline core {

struct AxisPosition {
  std::size_t row = 0;  ///< the last at or below the value; the first or last of the axis beyond its ends
  double share = 0.0;   ///< of the way to the next row; 0 at a row and beyond the ends
};

/// Needs a row at least. No allocation.
inline AxisPosition position_on(const std::vector<double>& axis, double value)
{
  const auto above = std::upper_bound(axis.begin(), axis.end(), value);
  if (above == axis.begin()) return {};
  const auto row = static_cast<std::size_t>(above - axis.begin() - 1);
  if (above == axis.end()) return {row, 0.0};
  return {row, (value - axis[row]) / (axis[row + 1] - axis[row])};
}

/// Linear between the rows, constant beyond them.
inline double linear_at(const std::vector<double>& values, const AxisPosition& at)
{
  if (at.share == 0.0) return values[at.row];
  return (1.0 - at.share) * values[at.row] + at.share * values[at.row + 1];
}

}  // namespace vrda::inline core
