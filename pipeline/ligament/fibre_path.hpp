/// The way a fibre takes from the reference to the moving object, and how its length changes with the pose.
#pragma once

#include <span>

#include "ligament/ligaments.hpp"

namespace vrda {

/// Both objects in S at one attitude and pose.
struct Placement {
  Eigen::Matrix3d R_S_reference = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_S_moving = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_S_moving_mm = Eigen::Vector3d::Zero();
};
Placement placed(const Attitude& attitude, const MovingPose& pose);

/// In S. One free segment crosses from the object that bears the wrap to the other (of a straight fibre: the
/// whole fibre). Only that segment pulls the objects towards each other.
struct FibrePath {
  double length_mm = 0.0;
  bool is_wrapped = false;
  /// Unit, along the crossing segment from the reference to the moving object: zero for two attachments in
  /// one place.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  /// The attachment where the crossing segment ends, and the object it belongs to.
  Eigen::Vector3d end_mm = Eigen::Vector3d::Zero();
  WrapBody end_body = WrapBody::moving;
  /// Second derivatives of the length over `end_mm`, the wrap held; 1/mm.
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
};

/// Allocates nothing.
FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const Placement& placement);

struct FibreWay {
  double length_mm = 0.0;  ///< as fibre_path's, not that of the points' chords
  bool is_wrapped = false;
};

/// Puts points of the fibre's way into `points_mm` (at least four), in S, from the reference's attachment to
/// the moving object's: evenly along a straight fibre; of a wrapped one evenly on the surface, from where it
/// comes to it to where it leaves it, and both attachments. Allocates nothing.
FibreWay fibre_way(const Fibre& fibre, const std::vector<Wrap>& wraps, const Placement& placement,
                   std::span<Eigen::Vector3d> points_mm);

}  // namespace vrda
