/// A femoral condyle: a ball swept along a planar spiral, so that distance, lowest points and rolling motion
/// are known in closed form.
///
/// Sagittal outline by its support function p(a): the extent of the condyle in the direction
/// n(a) = (-sin a, -cos a) of the sagittal plane, which points down when the femur is flexed by a. At flexion
/// a the condyle's lowest point is (x, y) = (-p'(a), -p(a)) for any shape, and the radius of curvature there
/// is p + p''. The radius decreases as
///   r(a) = posterior + extra * u^4,  u = max(0, 1 - a / spiral_end),
/// which has the closed-form support function  p = posterior + extra * q(a) - shift . (sin a, cos a)  with
///   q = u^4 - 12 u^2 / e^2 + 24 / e^4  before the spiral's end e, and 24 / e^4 cos(a - e) after it.
/// The coronal section is a circle: the surface is swept by a ball of that radius.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace vrda::geometry {

struct Condyle {
  double posterior_radius_mm = 20.0;
  double extra_radius_mm = 10.0;                       ///< distal radius minus posterior radius
  double spiral_end_rad = 1.92;                        ///< beyond it the outline is a circle
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< moves the outline in the sagittal plane (X, Y)
  double coronal_radius_mm = 18.0;                     ///< at most posterior_radius_mm
  double z_mm = 0.0;                                   ///< of the condyle's sagittal plane
  double first_rad = -0.5;                             ///< anterior end of the outline
  double last_rad = 2.4;                               ///< posterior end of the outline
};

/// p(a) and p'(a).
struct Support {
  double value_mm = 0.0;
  double slope_mm = 0.0;
};
Support support(const Condyle& condyle, double angle_rad);

double radius_mm(const Condyle& condyle, double angle_rad);

/// Centre of the swept ball where the outline's normal is n(a); its Z is the condyle's.
Eigen::Vector3d ball_centre_mm(const Condyle& condyle, double angle_rad);

/// The swept surface with precomputed samples for fast queries.
class CondyleSurface {
 public:
  explicit CondyleSurface(const Condyle& condyle);

  const Condyle& condyle() const { return condyle_; }

  /// Centre of the swept ball nearest to p (femur's frame).
  Eigen::Vector3d nearest_ball_centre_mm(const Eigen::Vector3d& p_mm) const;

  /// Signed distance; more than 12 mm outside the surface a lower bound.
  double signed_distance_mm(const Eigen::Vector3d& p_mm) const;

  /// Height of the condyle's underside over (x, z) in the femur's frame. Outside the condyle's silhouette:
  /// height of the equator plus the distance from the silhouette.
  double underside_mm(double x_mm, double z_mm) const;

 private:
  /// About 4 degrees apart, so that two steps bracket the minimum.
  static constexpr std::size_t n_samples = 41;

  Condyle condyle_;
  std::array<double, n_samples> angle_rad_{};                    // evenly spaced over the outline
  std::array<double, n_samples> centre_x_mm_{}, centre_y_mm_{};  // of the balls at those angles
  Eigen::Vector3d middle_mm_ = Eigen::Vector3d::Zero();
  double reach_mm_ = 0.0;  // bounding radius of the surface about the middle
};

}  // namespace vrda::geometry
