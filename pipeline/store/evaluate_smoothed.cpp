#include "store/evaluate_smoothed.hpp"

#include "core/error.hpp"

namespace vrda::store {
namespace {

/// du/dx of unit_coordinate.
double unit_slope(const AxisRange& range)
{
  return range.first_deg == range.last_deg ? 0.0 : 2.0 / (range.last_deg - range.first_deg);
}

}  // namespace

AxisRanges axis_ranges(const std::vector<double>& flexion_deg, const std::vector<double>& varus_deg)
{
  check(!flexion_deg.empty() && !varus_deg.empty(), "an axis must have at least one value");
  return {{flexion_deg.front(), flexion_deg.back()}, {varus_deg.front(), varus_deg.back()}};
}

LegendreTable legendre(double u, int degree)
{
  check(degree >= 0 && degree <= max_smoothed_degree, "the degree must not exceed the table");
  LegendreTable table;
  table.value[0] = 1.0;
  table.derivative[0] = 0.0;
  if (degree == 0) return table;
  table.value[1] = u;
  table.derivative[1] = 1.0;
  for (int n = 1; n < degree; ++n) {
    // Bonnet: (n + 1) P_{n+1} = (2n + 1) u P_n - n P_{n-1}, and P'_{n+1} = P'_{n-1} + (2n + 1) P_n.
    table.value[n + 1] = ((2 * n + 1) * u * table.value[n] - n * table.value[n - 1]) / (n + 1);
    table.derivative[n + 1] = table.derivative[n - 1] + (2 * n + 1) * table.value[n];
  }
  return table;
}

double unit_coordinate(double x_deg, const AxisRange& range)
{
  if (range.first_deg == range.last_deg) return 0.0;
  // Exactly -1 and 1 at the ends.
  return ((x_deg - range.first_deg) - (range.last_deg - x_deg)) / (range.last_deg - range.first_deg);
}

SmoothedValue evaluate(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges,
                       double flexion_deg, double varus_deg)
{
  const LegendreTable P = legendre(unit_coordinate(flexion_deg, ranges.flexion), set.degree);
  const LegendreTable Q = legendre(unit_coordinate(varus_deg, ranges.varus), set.degree);
  SmoothedValue result;
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    const std::int32_t i = set.exponents(k, 0), j = set.exponents(k, 1);
    const double coefficient = surface.coefficients[static_cast<std::size_t>(k)];
    result.value += coefficient * P.value[i] * Q.value[j];
    result.per_flexion += coefficient * P.derivative[i] * Q.value[j];
    result.per_varus += coefficient * P.value[i] * Q.derivative[j];
  }
  result.per_flexion *= unit_slope(ranges.flexion);
  result.per_varus *= unit_slope(ranges.varus);
  return result;
}

}  // namespace vrda::store
