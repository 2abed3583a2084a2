/// Motion of a model along its flexion, for functional registration. In: a motion model file and one of its sets.
/// Out: a curve, mm and rad, unscaled.
#pragma once

#include <string>

#include "calibration/joint_curve.hpp"

namespace vrda::calibrate {

/// Poses at steps of about 2 degrees, each at the set's own or balanced varus. Throws InputError with the file: a
/// sequence of frames, one flexion only, an unsolved pose.
calibration::JointCurve joint_curve(const std::string& file, const std::string& set);

}  // namespace vrda::calibrate
