/// The precise fit of one bone, from a start within some degrees and millimetres.
#pragma once

#include <functional>
#include <vector>

#include "geometry/coarse_fit.hpp"
#include "geometry/nearest_surface.hpp"
#include "geometry/surface_points.hpp"

namespace vrda::geometry {

/// A bone of the template placed on the subject's: p_subject = R * scale * p_template + t.
struct BoneFit {
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< along the template's axes
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_mm = Eigen::Vector3d::Zero();
  double residual_mm = 0.0;  ///< root mean square distance of the pairs kept, at the template's size
  /// The same of all points; one farther than 5 mm or without counterpart counts as 5 mm.
  /// Known points count with their weight, one farther than 15 mm as 15 mm.
  double mismatch_mm = 0.0;

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_template_mm) const
  {
    return R * scale.cwiseProduct(p_template_mm) + t_mm;
  }
  /// Unit normal of the placed surface.
  Eigen::Vector3d normal(const Eigen::Vector3d& n_template) const
  {
    return (R * n_template.cwiseQuotient(scale)).normalized();
  }
};

/// Which scale is fitted.
enum class ScaleFreedom {
  held,        ///< that of the start
  similarity,  ///< one factor
  axes,        ///< similarity first, then a factor per axis, regularised to their mean
  near_start,  ///< held first, then a factor per axis, regularised to that of the start, least along Y
};

/// A point that is known of both, such as an epicondyle.
struct KnownPoint {
  Eigen::Vector3d template_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d subject_mm = Eigen::Vector3d::Zero();
};

struct BoneFitOptions {
  ScaleFreedom freedom = ScaleFreedom::axes;
  double kept = 0.9;  ///< share of the pairs, the nearest
  /// Each weighs as much as a hundredth of the surface, so it matters where the surface does not
  /// determine the fit. One that stays 15 mm off weighs a quarter of that, and less beyond.
  std::vector<KnownPoint> known = {};
  std::function<bool()> is_stopped = {};  ///< polled; true: returns a fit that means nothing
};

/// Point-to-plane fit of the template's points, from the best of several starts. The points are fixed for a
/// template: random ones would move the frame by 1 to 7 degrees. Each step solves a linear least-squares
/// problem. Expects at least one start.
BoneFit fit_bone(const SurfacePoints& template_points, const NearestSurface& subject,
                 const std::vector<BoneFit>& starts, const BoneFitOptions& options);

}  // namespace vrda::geometry
