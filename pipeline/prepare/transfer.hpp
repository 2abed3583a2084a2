/// Transfers fibres, wraps and the kneecap of a template to a subject.
#pragma once

#include <string>
#include <vector>

#include "model/coordinates.hpp"
#include "prepare/knee_landmarks.hpp"
#include "prepare/template_joint.hpp"

namespace vrda::prepare {

/// A subject's bones in their anatomical frames (geometry/knee_fit.hpp): origin at the rotation centre.
struct SubjectBones {
  geometry::KneeSurfaces surfaces;
  Mesh fibula;                             ///< in the tibia's frame; empty: unknown
  std::vector<FibreEnds> known_ends = {};  ///< mm, in the frames of the bones
};

/// How far an attachment moved to the bone; NaN: it stays where the fit, or the user, has it.
struct AttachmentMove {
  double reference_mm = 0.0;
  double moving_mm = 0.0;
};

struct TransferredLigaments {
  model::Ligaments ligaments;         ///< anatomical frames; slack lengths are the template's
  std::vector<AttachmentMove> moves;  ///< [fibres]
};

/// `own_side`: the template of the subject's side. Attachments go through the fit, then to the nearest point
/// of bone at the template's own distance from it: at most 10 mm, or 25 mm to the fibula, to which LCL and
/// PFL belong. Without bone of the subject they stay. A known end replaces the one of the fit and goes to the
/// bone in the same way, unless it is within 2 mm of it: then it stays. Wraps take the bone's scales along
/// their own axes, with half-axes limited to a ratio below 5.
TransferredLigaments transferred_ligaments(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                                           const SubjectBones& subject);

/// The kneecap in the frame of the femur, at the template's position in extension.
struct Kneecap {
  geometry::BoneSurfaces surfaces;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< origin of its coordinates
  model::Ligaments ligaments;                           ///< anatomical frames; ends on it are the second
  /// Where the scan has it: follower_coordinates() of model/coordinates.hpp.
  JointCoordinates scanned = JointCoordinates::Zero();
  double gap_mm = 0.0;       ///< smallest distance from the femur there; negative: overlap
  double residual_mm = nan;  ///< of the registration; NaN: the template's own
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
};

/// A subject's patella, in the femur's frame as scanned, mm: the template's is registered onto it from
/// several flexions, and gives frame, centre and attachments. Throws InputError naming `file` for a mesh that
/// is no patella: less than a third or more than three times as large as expected (another unit), a residual
/// above 4 mm, a size beyond 0.5 to 2 times the template's, or a place behind the femur or more than 90 mm
/// from its centre. Cylinders of its lines are made small enough that no line ends inside one on the way
/// around the femur.
Kneecap registered_kneecap(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                           const SubjectBones& subject, const geometry::BoneSurfaces& patella,
                           const std::string& file);

/// The template's by the scales of the femur, moved along X until it touches the subject's. Cylinders as
/// above.
Kneecap fitted_kneecap(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                       const SubjectBones& subject);

}  // namespace vrda::prepare
