/// The tasks of the operator for each part of a calibration: what is drawn, which values a mark has, and the
/// checks of marks. Positions on the screen are in pixels of the frame buffer (x right, y down) before or
/// after pre-distortion as stated; tracker poses are in the tracker's frame, mm and unit quaternions.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "bench/calibration_file.hpp"
#include "calibration/functional_fit.hpp"

namespace vrda::calibration {

using bench::BenchFile;
using bench::BodyRole;
using bench::Calibration;
using bench::CalibrationLandmarks;
using bench::CalibrationMark;
using bench::CalibrationPart;
using bench::CalibrationPoint;
using bench::CalibrationRecord;
using bench::CalibrationRectangle;
using bench::CalibrationSettings;
using bench::Estimate;

/// What a part is checked and solved with.
struct PartInput {
  const BenchFile& bench;
  const Calibration& begun;  ///< marks and estimates so far
  const std::string& path;   ///< calibration file, for messages
  /// Motion of the model as given now, unscaled; nullptr: not given, only its record may be used.
  const calibration::JointCurve* joint = nullptr;
};

/// Kind of a task: what is drawn and which rows a mark has (schemas/calibration.md).
enum class TaskKind {
  scan_line,  ///< line one pixel wide over the eye's window; one row {column or row of the frame buffer}
  point,      ///< cross in the frame buffer; one row {x_px, y_px} as drawn
  rectangle_sides,  ///< two vertical pre-distorted lines; one row {x, y of the left line, x, y of the right
                    ///< one}, as drawn, at the height of the optical axis
  grid,    ///< pre-distorted grid; one row {k1, k2, centre_x, centre_y, at_x, at_y, spacing, turn_rad}
  number,  ///< number to be measured; one row {value}
  sweep,   ///< poses of a moving tool; rows {x, y, z, qw, qx, qy, qz, stage_mm}
  bend,    ///< the moving leg; a row per sample {pose of the femur's body (7), pose of the tibia's body (7)}
  hold,    ///< static tools; a row per sample {pose of probe or marker (7), pose of the body (7)}
  bullseye,  ///< pre-distorted cross on the marker, one eye; first row {x_px, y_px as drawn, stage_mm}, then
             ///< a row per sample {position of the marker (3), pose of the head (7) if tracked}
  model_pose,  ///< pose of the model; one row {shift_mm (3), turn_rad (3)} in the body frame
  stop,        ///< zeroes the stage at its stop; one row {stage_mm before}
  depth_check  ///< comparison of a drawn and a real frame; one row {}
};

/// A number that the operator adjusts by keys and potentiometer.
struct Dial {
  std::string name, unit;
  double value = 0.0, minimum = 0.0, maximum = 0.0, step = 0.0;
  /// A reading outside is refused once.
  double least_plausible = -std::numeric_limits<double>::infinity();
  double most_plausible = std::numeric_limits<double>::infinity();
};

struct Task {
  TaskKind kind = TaskKind::number;
  std::string name;         ///< unique within its part: "left eye, left edge, 2"
  std::string instruction;  ///< for the screen, up to three lines
  bool is_right = false;    ///< eye, for tasks of one eye
  bool is_column = false;   ///< scan_line: a column; else a row
  /// Start values; empty for sweep, bend, hold, stop, depth_check. scan_line: line; point: x, y as drawn
  /// (px); rectangle_sides: x of left and right line, as displayed; bullseye: x, y as displayed; grid: k1,
  /// k2, centre x, y (px as drawn), at x, y, spacing (px as displayed), turn (deg); number: value;
  /// model_pose: mm, degrees.
  std::vector<Dial> dials;
  bool is_start_valid = false;  ///< the start values may be confirmed as they are: a setting, not a reading
  int n_samples = 0;            ///< sweep, bend, hold, bullseye: number of tracker samples
  std::string tool;             ///< sweep, bend, hold, bullseye: tracker tool
  /// grid: columns and rows; point: column and row of the node relative to the grid centre.
  Eigen::Vector2d node = Eigen::Vector2d::Zero();
  int index = 0;  ///< index of the rectangle, model point or marker position
};

/// Tasks of a part, determined by the bench file and the earlier estimates. Names and `index` by part:
/// viewport: "left eye, left edge, 2" (index: Edge), then "left eye, width" (0) and "left eye, height" (1) of
/// the screen; distortion: "left eye, node -3, 2" or "left eye, grid 2"; eyepoints: "left eye, rectangle 1,
/// 2" (index 0, second repeat); ipd: "pupillary distance" (0), "left arm" (1), "right arm" (2), "image
/// distance" (3), "look"; rails: "x rail", "z rail"; stop: "stop"; probe: "sweep"; subject: name of the
/// distance; bullseye, head: "left eye, place 1" (index 0); leg, femur, tibia: name of the point, or "place
/// 1"; functional: "bend 1".
std::vector<Task> tasks_of(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

/// Requested marker position of a bull's-eye: -1, 0 or 1 for left to right, low to high, near to far. The
/// first six spread in all directions.
Eigen::Vector3i requested_marker_position(int index);

/// Range of tasks that are checked together: those of an eye, of a rail, of a bend, or all of the part.
struct TaskGroup {
  std::size_t begin = 0, end = 0;
};
TaskGroup task_group_of(CalibrationPart part, const std::vector<Task>& tasks, std::size_t task);

/// Expected accuracy of eyepoints.
std::string expected_eyepoint(const BenchFile& bench, const Calibration& calibration);

/// Tasks that need only the display and the person (thesis 8.1 to 8.4), and the subject's measurements.
std::vector<Task> viewport_tasks(const BenchFile& bench);
std::vector<Task> distortion_tasks(const BenchFile& bench, const Calibration& calibration);
std::vector<Task> eyepoint_tasks(const BenchFile& bench, const Calibration& calibration);
std::vector<Task> ipd_tasks(const BenchFile& bench);
std::vector<Task> subject_tasks(const BenchFile& bench);

/// "left eye"
std::string eye_text(bool is_right);

/// Tasks that need the tracker or the stage (thesis 8.5).
std::vector<Task> rail_tasks(const BenchFile& bench);
std::vector<Task> stop_tasks();
std::vector<Task> probe_tasks(const BenchFile& bench);
/// `part`: bullseye or head.
std::vector<Task> bullseye_tasks(CalibrationPart part, const BenchFile& bench,
                                 const Calibration& calibration);
/// `part`: leg, femur or tibia.
std::vector<Task> model_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);
std::vector<Task> bend_tasks(const BenchFile& bench);

}  // namespace vrda::calibration
