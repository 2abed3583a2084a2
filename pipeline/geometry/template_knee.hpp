/// The two bones of a knee, of a subject or of a template.
#pragma once

#include <Eigen/Core>

#include "model/frames.hpp"
#include "model/mesh.hpp"

namespace vrda::geometry {

/// A bone by the surfaces that are known of it; normals outward.
struct BoneSurfaces {
  Mesh bone;       ///< empty: unknown
  Mesh cartilage;  ///< empty: unknown
};

/// Both surfaces in one mesh.
Mesh joined(const BoneSurfaces& surfaces);

/// Exchanges inside and outside: faces and normals.
void reverse_winding(Mesh& mesh);

/// Both bones in one pose and one frame, mm.
struct KneeSurfaces {
  BoneSurfaces femur;
  BoneSurfaces tibia;
};

/// Reflected in Z = 0.
KneeSurfaces mirrored_z(const KneeSurfaces& knee);

/// A right knee in canonical axes near extension, to which others are compared.
struct TemplateKnee {
  KneeSurfaces surfaces;
  Eigen::Vector3d origin_mm{0.0, 0.0, 0.0};  ///< the rotation centre
};

/// Factor from the unit of the meshes to mm: 1, 10 or 1000. The geometric mean over both bones of the
/// second-largest extent along principal axes comes nearest to 75 mm: that is a joint's width, however much
/// of the shafts is there.
double unit_mm_of(const Mesh& femur, const Mesh& tibia);

/// Where both bones are near each other, and the direction from the tibia to the femur there.
struct JointRegion {
  Eigen::Vector3d centre_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d up{0.0, 1.0, 0.0};
  double nearest_mm = 0.0;  ///< smallest distance between samples of the bones
};
JointRegion joint_region(const Mesh& femur, const Mesh& tibia);

/// The knee that is registered where no other template is given: the generated "knee-template", divided into
/// bone and cartilage.
TemplateKnee generic_template();

}  // namespace vrda::geometry
