#include "tracking/six_numbers.hpp"

#include <cmath>

#include "core/frames.hpp"
#include "core/trig.hpp"

namespace vrda {

Pose pose_of(const SixNumbers& numbers)
{
  Pose pose = Pose::Identity();
  pose.linear() =
      rotation_z(numbers.turn_rad.z()) * rotation_y(numbers.turn_rad.y()) * rotation_x(numbers.turn_rad.x());
  pose.translation() = numbers.shift_mm;
  return pose;
}

SixNumbers six_numbers_of(const Pose& pose)
{
  const Eigen::Matrix3d R = pose.linear();
  SixNumbers six;
  six.shift_mm = pose.translation();
  const double cos_y = std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  six.turn_rad.y() = arc_tangent2(-R(2, 0), cos_y);
  // Straight up or down only the sum or difference of the other two counts: all of it is x.
  constexpr double straight = 1e-12;
  if (cos_y < straight) {
    six.turn_rad.x() = arc_tangent2(-R(1, 2), R(1, 1));
  } else {
    six.turn_rad.x() = arc_tangent2(R(2, 1), R(2, 2));
    six.turn_rad.z() = arc_tangent2(R(1, 0), R(0, 0));
  }
  return six;
}

}  // namespace vrda
