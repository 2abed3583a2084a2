/// The virtual bench: a bench and a person of which everything is known, where its things are during a task,
/// and the samples that a tracker and a board make of it.
#pragma once

#include "bench/devices.hpp"
#include "calibration/distortion_fit.hpp"
#include "calibration/drawing.hpp"

namespace vrda::calibration {

struct VirtualNoise {
  double alignment_px = 0.5;  ///< of each coordinate of an aligned position
  double tracker_mm = 0.1;    ///< of each coordinate of a position
  double tracker_deg = 0.03;  ///< of the rotation about each axis
  double touch_mm = 0.1;      ///< of the tip's position on a touched point
  double ruler_mm = 0.1;      ///< of screen sizes
  double pupillometer_mm = 0.5;
  double landmark_mm = 1.0;                ///< of a distance between landmarks
  double model_mm = 1.0, model_deg = 2.0;  ///< root mean square deviation of the joint from the model
};

/// The subject's joint: the model's motion with a smooth deviation, of which each coordinate is a random
/// sinusoid of flexion about a random offset.
struct VirtualJoint {
  using Coordinates = Eigen::Matrix<double, 6, 1>;  ///< mm, rad, at the joint's centre

  JointCurve curve;  ///< of the model in the subject's size
  Coordinates offset = Coordinates::Zero(), by_cosine = Coordinates::Zero(), by_sine = Coordinates::Zero();

  Pose X_femur_tibia(double flexion_rad) const;
};

struct VirtualTruth {
  std::uint64_t seed = 1;
  /// True eyes (their `visible` is rounded from `edges_px` to whole pixels), poses and scale.
  Calibration calibration;
  std::array<view::ShownBox, 2> edges_px;  ///< borders of the visible area, fractional px
  std::array<Eigen::Vector2d, 2> screen_mm;
  Eigen::Vector3d z_rail_table = Eigen::Vector3d::UnitZ();  ///< unit vector, not exactly perpendicular to X
  double z_rail_above_mm = 0.0;           ///< y on the table where the z rail crosses the x rail
  double reference_plane_table_mm = 0.0;  ///< z of the first rectangle on the table
  double grid_depth_mm = 800.0, grid_spacing_mm = 40.0;
  std::array<GridPose, 2> grids;  ///< where each eye sees the grid
  Eigen::Vector3d tip_probe_mm = Eigen::Vector3d::Zero();
  Pose X_tracker_leg = Pose::Identity();    ///< of the leg's (femur's) body, at rest
  Pose X_tracker_shank = Pose::Identity();  ///< of the tibia's body
  Pose X_tracker_headbody = Pose::Identity();
  std::optional<VirtualJoint> joint;  ///< required for bends
};

/// Equal seeds give equal benches. Quantities that the bench file gives with a standard deviation
/// (alignment_sd_rad, sight_sd_px, eye_height_sd_mm) are drawn with it.
VirtualTruth virtual_truth(const BenchFile& bench, std::uint64_t seed);

/// The joint of the bench's subject; `curve`: of the model, unscaled.
VirtualJoint virtual_joint(const VirtualTruth& truth, const JointCurve& curve, const VirtualNoise& noise);

/// Built-in bench file for `calibrate --virtual` without --bench.
const std::string& virtual_bench_text(HeadKind head = HeadKind::stage);

// Where things are, and the samples of it.

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
