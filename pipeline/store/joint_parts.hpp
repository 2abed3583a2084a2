/// Ligaments and names of a joint as they are drawn: by the player and in exported scenes. In: a motion
/// model. Points in canonical axes of their body, mm.
#pragma once

#include <string>
#include <vector>

#include "model/ligaments.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

enum class JointBody { reference, moving };

/// Width of the object's contact parts relative to the plateau of a knee, 80 mm: the scale of markers.
double width_ratio(const Body& moving);

/// The name of a body on screen: of a knee "femur" and "tibia", otherwise the motion model's.
std::string displayed_name(const store::MotionModel& model, JointBody body);

/// A name midway between two points, one on each body or both on the same.
struct JointLabel {
  std::string text;
  JointBody first = JointBody::reference, second = JointBody::reference;
  Eigen::Vector3d first_mm = Eigen::Vector3d::Zero(), second_mm = Eigen::Vector3d::Zero();
};

/// Both bodies, each ligament (model::ligament_of: the bundles of one count as one) at the middle
/// of its fibres, and medial and lateral if the joint has compartments.
std::vector<JointLabel> joint_labels(const store::MotionModel& model);

/// The model's fibres; may be empty.
model::Ligaments ligaments_of(const store::MotionModel& model);

}  // namespace vrda::store
