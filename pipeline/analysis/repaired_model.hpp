/// Repair of a motion model that is a sequence of frames.
#pragma once

#include <string>

#include "analysis/repair.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// The motion of a model, of a repaired one the measured motion, so that a repair can be repeated with other
/// options; `file` for messages. Throws InputError for a grid, a frame without a pose, and a
/// Delta that differs between frames.
MeasuredMotion measured_motion(const store::MotionModel& model, const std::string& file);

/// The bodies of that model for its Delta.
analysis::AuditScene scene_of(const store::MotionModel& model);

/// `model` with the repaired frames: attitudes, poses, gaps, contacts and clinical angles of the repaired
/// motion, and /repair with `measured`. Fibres and audits are left out: they belong to the measured poses.
store::MotionModel repaired_model(const store::MotionModel& model, const MeasuredMotion& measured,
                                  const RepairedMotion& motion, const MeasurementNoise& noise);

}  // namespace vrda::analysis
