#include "reduce/rolling.hpp"

#include <algorithm>
#include <cmath>

#include "core/helical_axis.hpp"

namespace vrda {
namespace {

double forward_mm(const Eigen::Vector3d& way_mm)
{
  const double length_mm = std::sqrt(way_mm.x() * way_mm.x() + way_mm.y() * way_mm.y());
  return way_mm.x() < 0.0 ? -length_mm : length_mm;
}

double shared_mm(double a_mm, double b_mm)
{
  if (a_mm * b_mm <= 0.0) return 0.0;
  return a_mm > 0.0 ? std::min(a_mm, b_mm) : std::max(a_mm, b_mm);
}

}  // namespace

Rolling rolling_between(const Bearing& start, const Bearing& end)
{
  const Eigen::Matrix3d R_reference_moving =
      orientation_midway(start.X_reference_moving, end.X_reference_moving);
  Rolling rolling;
  rolling.reference_mm =
      forward_mm(R_reference_moving.transpose() * (end.p_reference_mm - start.p_reference_mm));
  rolling.moving_mm = forward_mm(end.p_moving_mm - start.p_moving_mm);
  rolling.rolling_mm = shared_mm(rolling.reference_mm, rolling.moving_mm);
  rolling.sliding_mm = rolling.moving_mm - rolling.reference_mm;
  return rolling;
}

}  // namespace vrda
