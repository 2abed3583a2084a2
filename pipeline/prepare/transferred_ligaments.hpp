/// Transfers fibres and wraps of a template to a subject.
#pragma once

#include <vector>

#include "prepare/knee_landmarks.hpp"

namespace vrda::prepare {

/// A subject's bones in their anatomical frames (registration/knee_fit.hpp): origin at the rotation centre.
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
  model::Ligaments ligaments;      ///< anatomical frames; slack lengths are the template's
  std::vector<AttachmentMove> moves;  ///< [fibres]
};

/// `own_side`: the template of the subject's side. Attachments go through the fit, then to the nearest point
/// of bone at the template's own distance from it: at most 10 mm, or 25 mm to the fibula, to which LCL and
/// PFL belong. Without bone of the subject they stay. A known end replaces the one of the fit and goes to the
/// bone in the same way, unless it is within 2 mm of it: then it stays. Wraps take the bone's scales along
/// their own axes, with half-axes limited to a ratio below 5.
TransferredLigaments transferred_ligaments(const TemplateJoint& own_side, const geometry::KneeFit& fit,
                                           const SubjectBones& subject);

}  // namespace vrda::prepare
