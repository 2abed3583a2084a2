/// Convex hull of two balls as a level-set field.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace vrda::geometry {

struct Ball {
  Eigen::Vector3d centre_mm;
  double radius_mm;
};

/// Neither ball may contain the other. The nearest ball's centre is offset from the foot of the perpendicular
/// by the perpendicular's length times the tangent of the hull's half angle.
class Hull {
 public:
  Hull(const Ball& a, const Ball& b)
      : start_(a),
        axis_(b.centre_mm - a.centre_mm),
        length_mm_(axis_.norm()),
        sine_narrowing_((a.radius_mm - b.radius_mm) / length_mm_),
        tangent_(sine_narrowing_ / std::sqrt(1.0 - sine_narrowing_ * sine_narrowing_))
  {
  }

  double signed_distance_mm(const Eigen::Vector3d& p) const
  {
    const Eigen::Vector3d from_start = p - start_.centre_mm;
    const double along_mm = from_start.dot(axis_) / length_mm_;
    const double across_sq_mm2 = std::max(0.0, from_start.squaredNorm() - along_mm * along_mm);
    const double nearest_mm = std::clamp(along_mm - std::sqrt(across_sq_mm2) * tangent_, 0.0, length_mm_);
    const Eigen::Vector3d centre = start_.centre_mm + nearest_mm / length_mm_ * axis_;
    return (p - centre).norm() - (start_.radius_mm - nearest_mm * sine_narrowing_);
  }

 private:
  Ball start_;
  Eigen::Vector3d axis_;
  double length_mm_, sine_narrowing_, tangent_;
};

}  // namespace vrda::geometry
