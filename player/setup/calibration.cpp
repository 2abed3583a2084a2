#include "setup/calibration.hpp"

#include <cmath>

#include "core/trig.hpp"

namespace vrda {
namespace {

Eye nominal_eye(const Viewport& window, double x_mm)
{
  constexpr double nominal_distance_px = 880.0;
  Eye eye;
  eye.window = eye.visible = window;
  eye.distance_px = nominal_distance_px;
  eye.sight_px = {window.x + 0.5 * window.width, window.y + 0.5 * window.height};
  eye.position_head_mm = {x_mm, 0.0, 0.0};
  eye.distortion.centre_px = eye.sight_px;
  eye.distortion.unit_px = 0.5 * window.width;
  return eye;
}

}  // namespace

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

Calibration nominal_calibration(const BenchFile& bench)
{
  constexpr double nominal_ipd_mm = 64.0, nominal_depth_mm = 800.0;
  Calibration calibration;
  calibration.eyes.left = nominal_eye(bench.display.windows.left, -0.5 * nominal_ipd_mm);
  calibration.eyes.right = nominal_eye(bench.display.windows.right, 0.5 * nominal_ipd_mm);
  calibration.image_distance_mm = nominal_depth_mm;
  calibration.X_table_eyes.shift_mm = {0.0, 0.0, nominal_depth_mm};
  return calibration;
}

void require_usable(const Calibration& calibration, const std::string& path)
{
  require_usable(calibration.eyes.left, path, "left");
  require_usable(calibration.eyes.right, path, "right");
}

}  // namespace vrda
