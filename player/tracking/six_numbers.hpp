/// Poses in numbers that can be adjusted one by one.
#pragma once

#include "core/mesh.hpp"

namespace vrda {

/// Turned about the fixed axes x, then y, then z, then shifted.
struct SixNumbers {
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
};
Pose pose_of(const SixNumbers& numbers);
SixNumbers six_numbers_of(const Pose& pose);

}  // namespace vrda
