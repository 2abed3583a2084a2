/// Random poses, noise and markers for the tests of tracking.
#pragma once

#include <random>

#include "bench/rigid_body.hpp"

namespace vrda::test {

/// Any rotation, and a translation of up to a metre in each coordinate.
Pose random_pose(std::mt19937_64& random);
Eigen::Vector3d random_vector(std::mt19937_64& random, double largest);
/// Independent in each coordinate.
Eigen::Vector3d noise_of(std::mt19937_64& random, double sd);

/// The thesis's leg: three markers on the thigh, three on the shank, some 400 mm apart.
bench::RigidBody leg_body();
/// All markers of a body in the tracker's frame.
bench::MarkerRow seen_at(const bench::RigidBody& body, const Pose& X_tracker_body);

/// Angle of the rotation between two poses, and distance between their images of `p_mm`.
double turn_between_rad(const Pose& a, const Pose& b);
double distance_mm(const Pose& a, const Pose& b, const Eigen::Vector3d& p_mm = Eigen::Vector3d::Zero());

}  // namespace vrda::test
