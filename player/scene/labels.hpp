/// Where the names of bones, ligaments and compartments are drawn.
#pragma once

#include "motion/joint_parts.hpp"
#include "scene/scene.hpp"

namespace vrda::scene {

/// The label's point, world.
Eigen::Vector3d place_of(const motion::JointLabel& label, const JointFrames& frames);

}  // namespace vrda::scene
