/// Points that the user knows of a knee (`vrda prepare --landmarks`): schemas/prepare.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/document.hpp"
#include "model/frames.hpp"
#include "prepare/template_joint.hpp"

namespace vrda::prepare {

enum class Bone { femur, tibia };  ///< the fibula belongs to the tibia

struct NamedPoint {
  std::string name;  ///< "medial_epicondyle", ...
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

/// Attachments of a fibre of the template, as far as they are known.
struct FibreEnds {
  std::string name;
  std::optional<Eigen::Vector3d> femur, tibia;
};

struct NamedDistance {
  std::string from, to;  ///< landmarks of one bone
  double mm = 0.0;
};

/// Points in the coordinates and the unit of the mesh files.
struct KneeLandmarks {
  core::Document document;  ///< for messages
  std::vector<NamedPoint> points;
  std::vector<FibreEnds> fibres;
  std::vector<NamedDistance> distances;
};

/// Throws InputError naming file, line and key for a text that violates schemas/knee_landmarks.schema.json, a
/// fibre without an end or a second time, and a distance between two bones or of a point from itself.
KneeLandmarks read_knee_landmarks(const std::string& file, std::string_view text);

/// Throws InputError for a fibre that the template does not have.
void check_fibre_names(const KneeLandmarks& landmarks, const model::Ligaments& ligaments);

Bone bone_of(const std::string& landmark);

/// Where the template has a landmark: the mean of the vertices within 1 mm of its outermost one. Empty
/// without the bone.
std::optional<Eigen::Vector3d> landmark_mm(const TemplateJoint& joint, const std::string& name);

/// The landmarks of one bone for the fit, by a right template.
std::vector<geometry::KnownPoint> known_points(const KneeLandmarks& landmarks,
                                               const TemplateJoint& right_template, Bone bone);

/// Distance of each landmark from that of the fitted template; NaN: the template does not have it. Throws
/// InputError for one that is more than 30 mm off, which is in other coordinates or another unit.
std::vector<double> landmark_residuals_mm(const KneeLandmarks& landmarks, const TemplateJoint& own_side,
                                          const geometry::KneeFit& fit);

/// Three factors per bone of the template along canonical axes, without meshes of the subject: fitted to the
/// distances of the file and to those between any two points and fibre ends of one bone, with a weight on
/// equal factors. A bone without a distance takes the mean factor of the other.
struct LandmarkScales {
  Scaling femur, tibia;  ///< distances: |factor * (a - b)|
  std::vector<std::string> warnings;
};
/// Throws InputError without any distance, and for a factor outside 0.5 to 2.
LandmarkScales landmark_scales(const KneeLandmarks& landmarks, const TemplateJoint& own_side, double unit_mm);

// Transfers fibres and wraps of a template to a subject.

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

}  // namespace vrda::prepare
