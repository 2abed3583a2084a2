/// Accuracy of calibrations against ground truth, and coverage of their confidence intervals.
#pragma once

#include "calibration/operator.hpp"
#include "calibration/truth.hpp"

namespace vrda::calibration {

/// Found minus true value of every parameter of the estimate, in its units; poses as in bench::Estimate.
Eigen::VectorXd errors_of(const bench::Estimate& estimate, const VirtualTruth& truth);

/// Overlay error at one target for one eye: where its image is seen against its true direction.
struct TargetError {
  double mm = 0.0;  ///< perpendicular to the line of sight, at the target's distance
  double arc_min = 0.0;
};
/// 20 points of a working volume of 160 x 240 x 120 mm about the knee, both eyes: 40 errors. The leg's pose
/// has tracker noise; `index` selects the noise.
std::vector<TargetError> target_errors(const Calibration& found, const BenchFile& bench,
                                       const VirtualTruth& truth, const VirtualNoise& noise,
                                       std::uint64_t index = 0);

/// State before calibration: nominal eyes at tape-measured positions (10 mm, whole degrees). Table, stage,
/// leg and size are exact; otherwise errors would be metres and unrelated to the display.
Calibration uncalibrated(const BenchFile& bench, const VirtualTruth& truth);

struct NumberStatistics {
  std::string part, name, unit;
  int n = 0, n_within = 0;       ///< of the 95 % intervals containing the truth
  double rms_error = 0.0;        ///< of found minus true values
  double mean_half_width = 0.0;  ///< of the intervals
};

/// Overlay error of both bones at the joint (calibration::joint_error_mm, root mean square).
struct JointError {
  double by_landmarks_mm = 0.0, functional_mm = 0.0;
};
/// Requires the truth's joint and a calibration with the part functional.
JointError joint_error(const Calibration& found, const VirtualTruth& truth);

struct VirtualStatistics {
  int n_benches = 0, n_refused = 0;  ///< n_refused: benches where some marks had to be repeated
  std::vector<NumberStatistics> numbers;
  std::vector<TargetError> before,
      after;  ///< all target errors, by uncalibrated() and by the found calibration; empty for a joint
  std::vector<JointError> joints;  ///< of each bench; empty without a joint
};

struct VirtualRun {
  std::uint64_t first_seed = 1;
  int n_benches = 0, n_threads = 1;
  VirtualNoise noise = {};
  /// Motion of the model, unscaled: only the part functional and its dependencies are done.
  std::optional<calibration::JointCurve> joint = std::nullopt;
};

/// Runs the whole procedure of `bench` on the benches first_seed, first_seed + 1, ...; the result is the
/// same for any number of threads.
VirtualStatistics virtual_statistics(const BenchFile& bench, const VirtualRun& run);

// Positions at which a simulated operator sees things aligned: true optics on one side, the
// drawing by the calibration found so far on the other.

/// Pose of the head with its stage `stage_mm` from the stop.
Pose X_tracker_eyes(const Calibration& calibration, double stage_mm);

/// Vertical sides of a rectangle, parallel to the table's Y: x and z on the table.
struct RectangleSides {
  double left_table_mm = 0.0, right_table_mm = 0.0, z_table_mm = 0.0;
};
/// Sides of rectangle `index`, in front of the head with its stage at the stop.
RectangleSides rectangle_sides(const BenchFile& bench, const VirtualTruth& truth, std::size_t index);

/// Where a point of the table is seen with the stage at its stop; undistorted px.
Eigen::Vector2d seen_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector3d& p_table_mm);

/// The first (left, top) or last (right, bottom) column or row at least half of which is visible, for a
/// border at `border_px`.
double scan_reading(double border_px, bool is_last);

/// Position in the frame buffer at which a node of the physical grid must be drawn.
Eigen::Vector2d drawn_node_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& node);

/// Vertical line x = `value` in undistorted px, drawn through the pre-distortion of `drawing`.
struct SideLine {
  view::Eye drawing;
  double row_px = 0.0;  ///< y of the principal point
};
/// The value at which the eye sees the line on the side at x, z of the table, plus an offset of `off_px` in
/// the frame buffer.
double side_value(const SideLine& line, const VirtualTruth& truth, bool is_right,
                  const Eigen::Vector2d& side_table_mm, double off_px);

/// The cross's position (undistorted px of `drawing`) at which the eye sees it on a marker seen at
/// `seen_px`, plus an offset of `off_px` in the frame buffer.
Eigen::Vector2d cross_value(const view::Eye& drawing, const VirtualTruth& truth, bool is_right,
                            const Eigen::Vector2d& seen_px, const Eigen::Vector2d& off_px);

}  // namespace vrda::calibration
