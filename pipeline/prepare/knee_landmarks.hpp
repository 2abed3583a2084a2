/// Points that the user knows of a joint (`vrda prepare --landmarks`): schemas/prepare.md.
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
/// fibre without an end or a second time, and a distance between two bones or of a point from itself. Points
/// of 3D Slicer are named by their labels: a landmark, or FIBRE.femur and FIBRE.tibia; they are converted to
/// the space and the unit of the meshes.
struct LandmarkSpace {
  std::string space;  ///< LPS, RAS, or empty: unknown
  double unit_mm = 1.0;
};
KneeLandmarks read_knee_landmarks(const std::string& file, std::string_view text,
                                  const LandmarkSpace& meshes = {});

/// The same for another joint: schemas/joint_landmarks.schema.json.
std::vector<NamedPoint> read_joint_landmarks(const std::string& file, std::string_view text,
                                             const LandmarkSpace& meshes = {});

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

}  // namespace vrda::prepare
