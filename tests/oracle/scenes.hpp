/// What the oracle is asked about: two objects and random poses of them.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "proximity/placed.hpp"

namespace vrda::test {

/// A scene's two objects in the solver frame at zero attitude.
struct TwoObjects {
  TreeMesh reference;
  TreeMesh moving;
};

/// Every generated shape, the ball's dish in all its sections and with a hole.
const std::vector<std::string>& generated_scenes();
/// The real knees that have a job.
const std::vector<std::string>& real_knee_scenes();

/// By name from either list; real knees need their data.
TwoObjects two_objects(const std::string& scene);

/// Where a pose was put, by its travel along Delta from the first touch.
enum class Zone {
  apart,    ///< 0.01 to 20 mm before it
  milli,    ///< 1e-4 to 1e-3 mm before or beyond it
  micro,    ///< 1e-7 to 1e-6 mm
  nano,     ///< 1e-10 to 1e-9 mm
  deep,     ///< 0.01 to 10 mm beyond it
  anywhere  ///< from below to above the reference
};

struct AskedPose {
  MovingPose pose;
  Zone zone = Zone::anywhere;
};

/// Poses round one touch.
constexpr int poses_a_touch = 10;

/// One attitude and the poses at it, poses_a_touch for each of `n_touches` touches.
struct AskedAttitude {
  Attitude attitude;
  TreeMesh reference;  ///< turned
  std::vector<AskedPose> poses;
};

/// A random attitude (one in five is zero, nothing turned); then random turns and shifts across Delta at
/// which the moving object, coming from below, meets the reference.
AskedAttitude random_attitude(const TwoObjects& objects, int n_touches, std::mt19937_64& random);

}  // namespace vrda::test
