#include "knee_curve.hpp"

#include <cmath>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"

namespace vrda::test {

calibration::JointCurve knee_curve()
{
  calibration::JointCurve curve;
  curve.centre_mm = {5.0, -3.0, 2.0};
  curve.step_rad = rad_from_deg(3.0);
  for (int k = 0; k <= 30; ++k) {
    const double flexion_rad = k * curve.step_rad, share = k / 30.0;
    const Eigen::Matrix3d R = rotation_z(-flexion_rad) * rotation_x(rad_from_deg(3.0) * share * share) *
                              rotation_y(rad_from_deg(15.0) * std::sqrt(share + 0.01));
    const Eigen::Vector3d at_mm(-12.0 * share * share, 3.0 * share * (1.0 - share), 2.0 * share);
    calibration::JointCurve::Knot knot;
    knot << at_mm + curve.centre_mm - R * curve.centre_mm, bench::turn_of(R);
    curve.knots.push_back(knot);
  }
  return curve;
}

}  // namespace vrda::test
