/// Poses of everything on a simulated bench, the samples that tracker and encoder send of them, and what an
/// eye sees.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bench/devices.hpp"
#include "bench/simulation.hpp"
#include "calibration/drawing.hpp"
#include "calibration/truth.hpp"

namespace vrda::calibration {

struct BenchPoses {
  double stage_mm = 0.0;  ///< from the stop
  Pose X_tracker_eyes = Pose::Identity();
  Pose X_tracker_headbody = Pose::Identity();
  Pose X_tracker_tool = Pose::Identity();  ///< of the task's tool
  std::optional<Pose> X_tracker_shank;     ///< of the tibia's body, if the leg is not at rest
};

/// At rest: the head's stage `stage_mm` from its stop, the eyes moved by `X_eyes_moved`.
BenchPoses resting_poses(const VirtualTruth& truth, double stage_mm = 0.0,
                         const Pose& X_eyes_moved = Pose::Identity());

/// Puts the tip of the probe, with orientation `R`, at a point of the tracker.
void put_tip_at(const VirtualTruth& truth, const Eigen::Vector3d& tip_tracker_mm, const Eigen::Matrix3d& R,
                BenchPoses& poses);

/// Pose of the head with its stage `stage_mm` from the stop.
Pose X_tracker_eyes(const Calibration& calibration, double stage_mm);
/// True pose of a body, at rest, and of the model in it.
const Pose& X_tracker_body(const VirtualTruth& truth, BodyRole role);
Pose X_body_model(const Calibration& calibration, BodyRole role);

/// Random numbers of where a hand puts something, by `kind` and `index`.
RandomSequence draws_of_hand(const VirtualTruth& truth, std::uint64_t kind, int index);
/// Each coordinate evenly distributed within +-`most`.
Eigen::Vector3d even_vector(RandomSequence& draws, double most);
/// Error of an aligned position, px of the frame buffer.
Eigen::Vector2d alignment_off_px(const TaskContext& context);

/// Adds tracker noise to a pose.
Pose measured(const Pose& X, const VirtualNoise& noise, RandomSequence& draws);

struct FrameFacts {
  std::int64_t time_ns = 0;
  std::string tool;  ///< tool of BenchPoses::X_tracker_tool
  /// Offset of the encoder before it was zeroed at the stop.
  double stage_offset_mm = 0.0;
  bool is_stage_zeroed = false;
  VirtualNoise noise;
};

/// The stage's count, then every tool of the tracker in order; unused tools are not visible.
std::vector<bench::Sample> tracker_frame(const BenchFile& bench, const VirtualTruth& truth,
                                         const BenchPoses& poses, const FrameFacts& facts,
                                         RandomSequence& draws);

/// Where lines of the frame buffer are seen through the true optics, clipped to the visible area.
std::vector<DrawnLine> seen_lines(std::span<const DrawnLine> drawn, const VirtualTruth& truth);

}  // namespace vrda::calibration
