/// The stability search and its predictions of rotation and translation from the contacts (thesis 3.4
/// and 3.5), which depend only on the directions of the reactions.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "model/step_record.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {

struct RotationPrediction {
  int sign = 0;                                         ///< +1 or -1 about Delta; 0: no rotation
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< the axis parallel to Delta passes here
};

/// Rotation about the mean of the contact points if the moments of all normals agree in sign; otherwise about
/// the mean of the contact points for which they agree, if they agree there too and no normal passes through
/// it. Contacts without a moment are ignored otherwise. No rotation with fewer than two contacts.
/// Source: thesis 3.4.
RotationPrediction predict_rotation(const std::vector<contact::Contact>& contacts);

/// The same about a given axis, for an object that may not translate.
RotationPrediction predict_rotation_about(const std::vector<contact::Contact>& contacts,
                                          const Eigen::Vector3d& centre_mm);

/// Moment of a contact's normal about the axis through `centre`, mm (unit normal).
double moment_about_mm(const contact::Contact& contact, const Eigen::Vector3d& centre);

Eigen::Vector3d mean_point(const std::vector<contact::Contact>& contacts);

/// Sum over the four half-axes perpendicular to Delta of the mean positive component of the normals' unit
/// projections: a vector perpendicular to Delta, each component in [-1, 1]. A normal parallel to Delta does
/// not contribute. Source: thesis 3.5.
Eigen::Vector3d predict_translation(const std::vector<contact::Contact>& contacts);

/// Direction of steepest ascent along Delta: a translation perpendicular to Delta and a rotation about it.
struct Ascent {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< mm perpendicular to Delta per mm of motion
  double turn_rad_per_mm = 0.0;                         ///< rad about Delta per mm of motion
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< the axis of rotation passes here
  double rise = 0.0;  ///< mm along Delta per mm of motion; 0: the contacts block every motion
};

/// The motion of unit length with the fastest rise along Delta. A contact of normal n whose point moves by v
/// allows a rise of n . v / (-n . Delta). The length of a motion is the norm of its translation and of its
/// rotation times `lever_mm`; without a lever there is no rotation. The rise is the distance from the origin
/// to the convex hull of these slopes: if the hull contains the origin, forces and, with a lever, moments
/// balance and no motion rises. Exact; a few iterations over the contacts. Held motions are not used; if a
/// translation is held, the rotation is about `origin_mm`.
Ascent predict_ascent(const std::vector<contact::Contact>& contacts,
                      std::optional<double> lever_mm = std::nullopt, const HeldMotions& held = {},
                      const Eigen::Vector3d& origin_mm = Eigen::Vector3d::Zero());

/// Solves one motion step from `seed`. Does not set the key of the result. A `stable` pose never overlaps and
/// is in contact within the translation resolution. Held motions keep the seed's value. Pure: same input,
/// same bits. Source: thesis 3.2 to 3.7. Differs: travel along Delta is exact instead of stepped, normals are
/// those of the side of least curvature, and a step size is restored only by a motion to a new pose.
StepRecord find_stable_pose(const Joint& joint, const Attitude& attitude, const MovingPose& seed,
                            const SearchOptions& options, const SearchObserver& observer = {});

}  // namespace vrda::solve
