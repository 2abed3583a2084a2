/// Pose, size and side of a knee in any orientation, without a start value.
#pragma once

#include "geometry/knee_surfaces.hpp"

namespace vrda::geometry {

/// A template of one side placed on the subject: p_subject = scale * R * p_template + t.
struct SimilarityFit {
  double scale = 1.0;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_mm = Eigen::Vector3d::Zero();
  /// Root mean square distance of the nearest 80 % of the template's points, at the template's size;
  /// infinite where too few points have a counterpart.
  double residual_mm = std::numeric_limits<double>::infinity();
  double flexion_rad = 0.0;  ///< by which the template's femur was turned before the fit
};

struct CoarseFit {
  SimilarityFit right;      ///< of the template
  SimilarityFit left;       ///< of the mirrored template
  double nearest_mm = 0.0;  ///< smallest distance between samples of the subject's bones
};

/// Both bones as one: 12 turns about the direction through the joint, of the template and of the mirrored
/// template, each followed by a trimmed similarity fit; the best four of each side are fitted further. Moved
/// and mirrored subjects give moved and mirrored fits.
CoarseFit coarse_fit(const KneeSurfaces& subject, const TemplateKnee& reference);

}  // namespace vrda::geometry
