#include "calibration/place_estimate.hpp"

#include "core/trig.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

/// Turned about the fixed axes x, then y, then z: R = Rz Ry Rx. Straight up or down all of it is x.
Eigen::Vector3d turns_rad(const Eigen::Matrix3d& R)
{
  constexpr double straight = 1e-12;
  const double cos_y = R.col(0).head<2>().norm();
  const double y = arc_tangent2(-R(2, 0), cos_y);
  if (cos_y < straight) return {arc_tangent2(-R(1, 2), R(1, 1)), y, 0.0};
  return {arc_tangent2(R(2, 1), R(2, 2)), y, arc_tangent2(R(1, 0), R(0, 0))};
}

}  // namespace

Estimate place_estimate(const std::string& name, const Pose& X_fixed_moving,
                        const Eigen::Matrix<double, 6, 6>& covariance)
{
  Estimate estimate;
  for (const char* number : {"shift_x", "shift_y", "shift_z", "turn_x", "turn_y", "turn_z"}) {
    estimate.names.push_back(name + "." + number);
  }
  estimate.units = {"mm", "mm", "mm", "deg", "deg", "deg"};
  constexpr double deg = deg_from_rad(1.0);
  estimate.values.resize(6);
  estimate.values << X_fixed_moving.translation(), deg * turns_rad(X_fixed_moving.linear());
  Eigen::Matrix<double, 6, 1> units;
  units << 1.0, 1.0, 1.0, deg, deg, deg;
  estimate.covariance = units.asDiagonal() * covariance * units.asDiagonal();
  return estimate;
}

}  // namespace vrda
