/// Inputs of the oracle: two objects and random poses.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "geometry/placement.hpp"

namespace vrda::test {

/// The two objects of a scene in the solver frame at zero attitude.
struct TwoObjects {
  geometry::TreeMesh reference;
  geometry::TreeMesh moving;
};

/// All generated shapes, the ball's dish in all its sections and with a hole.
const std::vector<std::string>& generated_scenes();
/// The real knees that have a job.
const std::vector<std::string>& real_knee_scenes();

/// By name from either list; real knees require their data.
TwoObjects two_objects(const std::string& scene);

/// Range of a pose's travel along Delta relative to first contact.
enum class Zone {
  apart,    ///< 0.01 to 20 mm before contact
  milli,    ///< 1e-4 to 1e-3 mm before or beyond contact
  micro,    ///< 1e-7 to 1e-6 mm
  nano,     ///< 1e-10 to 1e-9 mm
  deep,     ///< 0.01 to 10 mm beyond contact
  anywhere  ///< from below to above the reference
};

struct TestPose {
  MovingPose pose;
  Zone zone = Zone::anywhere;
};

/// Poses around one contact.
constexpr int poses_per_contact = 10;

/// One attitude and its poses: poses_a_touch for each of `n_touches` contacts.
struct TestAttitude {
  Attitude attitude;
  geometry::TreeMesh reference;  ///< rotated
  std::vector<TestPose> poses;
};

/// A random attitude (one in five is zero, without rotation), then random rotations and translations
/// perpendicular to Delta at which the moving object, coming from below, touches the reference.
TestAttitude random_attitude(const TwoObjects& objects, int n_touches, std::mt19937_64& random);

}  // namespace vrda::test
