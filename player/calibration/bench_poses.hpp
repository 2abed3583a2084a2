/// Poses of everything on the bench during a task, and the samples that tracker and encoder send of them.
#pragma once

#include <optional>

#include "bench/calibration_file.hpp"
#include "bench/devices.hpp"
#include "bench/simulation.hpp"
#include "calibration/truth.hpp"

namespace vrda::calibration {

struct BenchPoses {
  double stage_mm = 0.0;  ///< from the stop
  Pose X_tracker_eyes = Pose::Identity();
  Pose X_tracker_headbody = Pose::Identity();
  Pose X_tracker_tool = Pose::Identity();  ///< of the task's tool
  std::optional<Pose> X_tracker_shank;     ///< of the tibia's body, if the leg is not at rest
};

/// Resting pose: the head's stage is at its stop.
BenchPoses resting_poses(const VirtualTruth& truth);

/// The marker on the carriage of the x rail (the stage's) or the z rail; `way` in [0, 1] is the progress of
/// the sweep, to the viewer's right or towards the viewer.
BenchPoses x_rail_poses(const VirtualTruth& truth, double way);
BenchPoses z_rail_poses(const VirtualTruth& truth, double way);

/// The probe's tip rests on a point of the table while the probe turns by 40 degrees about two axes.
BenchPoses pivot_poses(const VirtualTruth& truth, double way);

/// Position `index` of the marker (requested_marker_position in calibration_tasks/task.hpp), visible to both
/// eyes; the head moves between positions.
BenchPoses bullseye_poses(const BenchFile& bench, const VirtualTruth& truth, int index);

/// The probe's tip on `p_model_mm` of the leg's model, in a different orientation for each `index`, offset
/// by `off_mm` (tracker's axes).
struct TouchedPoint {
  BodyRole role = BodyRole::leg;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();
  int index = 0;
  Eigen::Vector3d off_mm = Eigen::Vector3d::Zero();
};
BenchPoses touch_poses(const VirtualTruth& truth, const TouchedPoint& touched);

/// The leg bends from the model's first flexion to about its last one and is stretched again. Requires the
/// truth's joint.
BenchPoses bend_poses(const VirtualTruth& truth, int index, double way);

/// Pose of the body that carries the model, at rest.
const Pose& X_tracker_body(const VirtualTruth& truth, BodyRole role);

/// Adds tracker noise to a pose.
Pose measured(const Pose& X, const VirtualNoise& noise, RandomSequence& draws);

struct FrameFacts {
  std::int64_t time_ns = 0;
  std::string tool;  ///< tool of Standing::X_tracker_tool
  /// Offset of the encoder before it was zeroed at the stop.
  double stage_offset_mm = 0.0;
  bool is_stage_zeroed = false;
  VirtualNoise noise;
};

/// The stage's count, then every tool of the tracker in order; unused tools are not visible.
std::vector<bench::Sample> tracker_frame(const BenchFile& bench, const VirtualTruth& truth,
                                         const BenchPoses& standing, const FrameFacts& facts,
                                         RandomSequence& draws);

}  // namespace vrda::calibration
