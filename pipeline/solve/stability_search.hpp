/// The two predictions of the stability search: which way contacts turn the moving object and which way
/// they push it (thesis 3.4 and 3.5). Only directions of reactions count, never their size.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "core/solver_options.hpp"
#include "core/step_record.hpp"
#include "solve/joint.hpp"

namespace vrda {

struct RotationPrediction {
  int sign = 0;                                         ///< +1 or -1 about Delta; 0: no rotation
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< the axis parallel to Delta passes here
};

/// Turns about the mean of the contact points when the moments of all normals agree in sign; otherwise about
/// the mean of those contact points that qualify as centres, once verified: there all must agree, and none
/// may pass through it. Contacts without a moment have no say elsewhere. Fewer than two contacts never turn.
/// Source: thesis 3.4.
RotationPrediction predict_rotation(const std::vector<Contact>& contacts);

/// Moment of a contact's normal about the axis through `centre`, mm (unit normal).
double moment_about_mm(const Contact& contact, const Eigen::Vector3d& centre);

Eigen::Vector3d mean_point(const std::vector<Contact>& contacts);

/// Sum over the four half-axes across Delta of the mean positive component of the normals' unit
/// projections: a vector across Delta, each component in [-1, 1]. A normal along Delta contributes
/// none. Source: thesis 3.5.
Eigen::Vector3d predict_translation(const std::vector<Contact>& contacts);

/// A motion under which all contacts give way: across Delta, and about it through `centre`.
struct Climb {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< mm across Delta a mm of motion
  double turn_rad_mm = 0.0;                             ///< rad about Delta a mm of motion
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double rise = 0.0;  ///< mm along Delta a mm of motion; 0: the contacts block every motion
};

/// The motion of unit length that lets the moving object rise fastest. A contact of normal n lets it rise
/// along Delta by n . v / (-n . Delta) while its point goes v. The length of a motion is that of its way and
/// of its turn times `lever_mm`, taken at right angles; without a lever it does not turn. The rise is the
/// distance of the convex hull of these slopes from the origin: where the hull holds the origin, forces and,
/// with a lever, moments balance and no motion leads up. Exact; a few passes over the contacts.
Climb predict_climb(const std::vector<Contact>& contacts, std::optional<double> lever_mm = std::nullopt);

/// Told of every move, in order.
using Watch = std::function<void(const SearchMove&)>;

/// Solves one motion step from `seed`. The key of the result is left as it is by default; a pose that is
/// `stable` never overlaps, and touches within the translation resolution. Pure: same input, same bits.
/// Source: thesis 3.2 to 3.7. Differs: travel along Delta is measured exactly instead of stepped, normals
/// come from the side of least curvature, and a step is restored only by a motion that led somewhere new.
StepRecord find_stable_pose(const Joint& joint, const Attitude& attitude, const MovingPose& seed,
                            const SearchOptions& options, const Watch& watch = {});

}  // namespace vrda
