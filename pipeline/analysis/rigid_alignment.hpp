/// The rigid transform of each body's frame that brings found poses nearest to measured ones: the frames of a
/// measurement and of the meshes rarely coincide.
#pragma once

#include <vector>

#include "model/mesh.hpp"

namespace vrda::analysis {

/// measured ~ X_reference * found * X_moving.
struct RigidAlignment {
  Pose X_reference = Pose::Identity();  ///< moves the found reference object to the measured one
  Pose X_moving = Pose::Identity();     ///< takes the measured moving object's vertices to the found one's
  double rms_mm = 0.0;   ///< distance left between both images of the points `alignment_points_mm`
  int n_determined = 0;  ///< directions of the twelve in which the poses determine both transforms
  bool is_converged = false;
};

/// Six points, this far from the rotation centre along the moving object's axes, carry the distance that is
/// minimised: half the width of a condyle pair, so that a degree counts as 0.5 mm.
inline constexpr double alignment_radius_mm = 30.0;

/// Least squares over both transforms, for all frames together. Both lists have the same length, at least 1.
/// Method: from the 24 rotations of a cube for X_reference, alternating closed-form fits (Umeyama (1991) IEEE
/// PAMI 13:376-380, without scale), then Gauss-Newton on both. The best of these gives the noise. From
/// the identity, Gauss-Newton then steps only along directions whose effect exceeds that noise (a hinge
/// leaves its axis undetermined, a short motion almost). Its result is used unless the best has less than
/// half its distance.
RigidAlignment rigid_alignment(const std::vector<Pose>& found, const std::vector<Pose>& measured,
                               const Eigen::Vector3d& rotation_centre_mm);

}  // namespace vrda::analysis
