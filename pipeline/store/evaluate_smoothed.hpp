/// Evaluation of smoothed surfaces between the attitudes of the grid.
#pragma once

#include <vector>

#include "store/motion_model.hpp"

namespace vrda::store {

/// First and last value of an axis. An axis with one value has both equal and maps to 0.
struct AxisRange {
  double first_deg = 0.0;
  double last_deg = 0.0;
};

struct AxisRanges {
  AxisRange flexion, varus;
};

/// Ranges of axes with at least one value each.
AxisRanges axis_ranges(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg);

/// Largest degree of a surface; tables of this size are on the stack.
inline constexpr int max_smoothed_degree = 20;

/// Legendre polynomials and their derivatives at one point of [-1, 1] (or a little outside).
struct LegendreTable {
  double value[max_smoothed_degree + 1] = {};
  double derivative[max_smoothed_degree + 1] = {};
};
LegendreTable legendre(double u, int degree);

/// Maps `x_deg` to [-1, 1]; 0 where the axis has one value.
double unit_coordinate(double x_deg, const AxisRange& range);

struct SmoothedValue {
  double value = 0.0;        ///< mm, degrees for theta
  double per_flexion = 0.0;  ///< derivative, per degree of flexion
  double per_varus = 0.0;    ///< derivative, per degree of varus; 0 where the axis has one value
};

/// Evaluates a surface at any attitude; outside the grid it extrapolates, with large errors.
/// Allocates nothing. `set` is the set of `surface`.
SmoothedValue evaluate(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges,
                       double flexion_deg, double varus_deg);

}  // namespace vrda::store
