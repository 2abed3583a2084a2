/// The frame of a hip, an ankle or a subtalar joint, from the surfaces of its two bones.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "model/ligaments.hpp"
#include "model/mesh.hpp"
#include "prepare/knee_landmarks.hpp"

namespace vrda::prepare {

/// The names of the bones of a knee, hip, ankle or subtalar joint.
struct JointBones {
  const char *reference, *moving;
};
JointBones bones_of(const std::string& joint);

/// Bone and cartilage of each, outward normals, in one pose; in the axes and the unit of the scan.
struct JointSurfaces {
  Mesh reference;  ///< pelvis, tibia or talus
  Mesh moving;     ///< femur, talus or calcaneus
  Mesh fibula;     ///< of an ankle; empty: not given
};

struct JointFrameOptions {
  std::string joint;                        ///< hip, ankle or subtalar
  std::string reference_file, moving_file;  ///< for messages
  std::optional<Side> side;                 ///< known side; absent: found
  std::optional<double> unit_mm;            ///< known unit; absent: found
  std::vector<NamedPoint> landmarks = {};   ///< in the unit of the scan
};

/// Canonical axes at the centre of the joint. Both bones have this frame, so zero is the pose of the scan.
struct JointFrame {
  double unit_mm = 1.0;
  Side side = Side::right;
  double side_margin = 0.0;  ///< sine by which the bones show `side`; below 0.1 it is not determined
  Pose X_scan_joint = Pose::Identity();  ///< mm
  double radius_mm = 0.0;                ///< of the head or of the trochlea; NaN: subtalar
  double residual_mm =
      0.0;              ///< of the head from the sphere (RMS); of the others from a surface of revolution
  double gap_mm = 0.0;  ///< lower quartile of the distance between the facing surfaces
  Eigen::Vector3d delta = Eigen::Vector3d::UnitY();  ///< the push, canonical
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< ankle, subtalar: about which they turn, canonical
  /// Of a hip: what is free of impingement within -100 to 20 degrees, without the last 5.
  double least_flexion_deg = -100.0, most_flexion_deg = 20.0;
  /// Of an ankle, canonical: from the ends of the axis, where the malleoli are, fans to both sides of the
  /// talus, which are nearly isometric as the collateral ligaments are.
  std::vector<model::Fibre> fibres;
  std::vector<std::string> found;  ///< from what each axis is
  std::vector<std::string> warnings;
};

/// Hip: the sphere of the head without the fovea; proximal from the shaft (a whole femur: to the middle of
/// the condyles), lateral from the symmetry of a whole pelvis, else the condyles, else the neck. Ankle:
/// lateral is the axis of revolution of the trochlea, proximal from the shaft of the tibia, anterior from the
/// head of the talus. Subtalar: the axis about which the facing surfaces slide best and their mean normal,
/// placed as in four measured feet. No axis depends on how far a bone of an ankle or a subtalar joint reaches
/// beyond the joint, unless its shaft is there. Throws InputError with the option as its field for bones that
/// are not those of the joint.
JointFrame joint_frame(const JointSurfaces& surfaces, const JointFrameOptions& options);

/// What each bone is thickened by where `n_bare` of both have no cartilage: of the gap in the scan, 0.5 mm
/// remain, so that no congruent surfaces overlap.
double joint_cartilage_mm(double gap_mm, int n_bare);

}  // namespace vrda::prepare
