/// Names of bones, ligaments and compartments, drawn as text at points of the joint.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda::scene {

/// The name of a body on screen: of a knee "femur" and "tibia", otherwise the motion model's.
std::string displayed_name(const store::MotionModel& model, Owner owner);

/// A name midway between two points, one on each body or both on the same.
struct JointLabel {
  std::string text;
  Owner first = Owner::reference, second = Owner::reference;
  Eigen::Vector3d first_mm = Eigen::Vector3d::Zero(), second_mm = Eigen::Vector3d::Zero();  ///< canonical
};

/// Both bodies, each ligament (ACL, PCL, MCL, LCL: bundles whose names begin so count as one) at the middle
/// of its fibres, and medial and lateral if the joint has compartments.
std::vector<JointLabel> joint_labels(const store::MotionModel& model);

/// The label's point, world.
Eigen::Vector3d place_of(const JointLabel& label, const JointFrames& frames);

}  // namespace vrda::scene
