/// What the operator is asked to do for a part, from its first task to its last.
#pragma once

#include <string>
#include <vector>

#include "setup/calibration.hpp"

namespace vrda {

/// What is shown, and what a mark's rows hold.
enum class TaskKind {
  scan_line,  ///< a line one pixel wide over the eye's window; one row {line}: column or row of the frame
              ///< buffer
  point,      ///< a cross in the frame buffer, as drawn; one row {x_px, y_px}
  sides,  ///< two vertical lines through the pre-distortion; one row {x, y of the left line as drawn, x, y of
          ///< the right one}: where each crosses the height of the sight
  grid,   ///< a pre-distorted grid; one row {k1, k2, centre_x, centre_y, at_x, at_y, spacing, turn_rad}
  number,    ///< a number to be read off and set; one row {value}
  sweep,     ///< places of a tool while it is moved; rows {x, y, z, qw, qx, qy, qz, stage_mm}
  hold,      ///< tools held still: a row each sample {probe's or marker's place (7), body's place (7)}
  bullseye,  ///< a cross through the pre-distortion for one eye, on the marker; first row {x_px, y_px as
             ///< drawn, stage_mm}, then a row each sample {marker's position (3), head's place (7) where it
             ///< is tracked}
  place,     ///< the model's six numbers; one row {shift_mm (3), turn_rad (3)} of the body's model
  stop,      ///< the stage is at its stop: it is zeroed; one row {stage_mm before}
  look       ///< the test object: is it where the real one is? one row {}
};

/// A number that keys and the potentiometer change.
struct Dial {
  std::string name, unit;
  double value = 0.0, least = 0.0, most = 0.0, step = 0.0;
};

struct Task {
  TaskKind kind = TaskKind::number;
  std::string name;         ///< unique in its part: "left eye, left edge, 2"
  std::string instruction;  ///< for the screen, up to three lines
  bool is_right = false;    ///< of tasks for one eye
  bool is_across = false;   ///< scan_line: a column that is moved across; else a row
  /// As they begin; empty for sweep, hold, stop and look. scan_line: the line; point: x, y as drawn (px);
  /// sides: x of the left line, of the right one, as shown; bullseye: x, y as shown; grid: k1, k2, centre x,
  /// y (px as drawn), at x, y, spacing (px as shown), turn (deg); number: it; place: three mm, three degrees.
  std::vector<Dial> dials;
  int n_samples = 0;  ///< sweep, hold, bullseye: wanted from the tracker
  std::string tool;   ///< sweep, hold, bullseye: the tracker's tool to be seen
  /// grid, point: the physical grid's nodes; the one of a point.
  Eigen::Vector2d node = Eigen::Vector2d::Zero();
  int index = 0;  ///< of the rectangle, point on the model, bull's-eye place that is meant
};

/// The same for the same bench and what earlier parts found. Names and `index`, by part:
/// viewport: "left eye, left edge, 2" (index: Edge), then "left eye, width" (0) and "left eye, height" (1)
/// of the screen; distortion: "left eye, node -3, 2" or "left eye, grid 2"; eyepoints: "left eye, rectangle
/// 1, 2" (index 0: the first rectangle, second time); ipd: "pupillary distance" (0), "left arm" (1), "right
/// arm" (2), "image distance" (3), "look"; rails: "x rail", "z rail"; stop: "stop"; probe: "sweep"; subject:
/// the name of the landmarks' distance; bullseye, head: "left eye, place 1" (index 0); leg, femur, tibia: the
/// point's name, or "place 1".
std::vector<Task> tasks_of(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

/// Where the marker of a bull's-eye is to be: -1, 0 or 1 for left to right, low to high, near to far. Six in
/// a row from the first spread in every direction.
Eigen::Vector3i marker_place(int index);

/// Tasks that are looked at together once they are done: those of an eye, a rail's, or all of the part.
struct TaskRound {
  std::size_t begin = 0, end = 0;
};
TaskRound round_of(CalibrationPart part, const std::vector<Task>& tasks, std::size_t task);

/// What is to be expected of it; often nothing.
std::vector<std::string> words_before(CalibrationPart part, const BenchFile& bench,
                                      const Calibration& calibration);
/// Its result, a line a number.
std::vector<std::string> words_after(CalibrationPart part, const Estimate& estimate);

/// Tasks that need nothing but the display and somebody who looks into it (thesis 8.1 to 8.4), and the
/// subject's measures.
std::vector<Task> viewport_tasks(const BenchFile& bench);
std::vector<Task> distortion_tasks(const BenchFile& bench, const Calibration& calibration);
std::vector<Task> eyepoint_tasks(const BenchFile& bench, const Calibration& calibration);
std::vector<Task> ipd_tasks(const BenchFile& bench);
std::vector<Task> subject_tasks(const BenchFile& bench);

/// "left eye"
std::string eye_text(bool is_right);
const Eye& eye_of(const Calibration& calibration, bool is_right);

/// Tasks that need the tracker or the stage (thesis 8.5).
std::vector<Task> rail_tasks(const BenchFile& bench);
std::vector<Task> stop_tasks();
std::vector<Task> probe_tasks(const BenchFile& bench);
/// Of `part` bullseye or head.
std::vector<Task> bullseye_tasks(CalibrationPart part, const BenchFile& bench,
                                 const Calibration& calibration);
/// Of `part` leg, femur or tibia.
std::vector<Task> model_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

}  // namespace vrda
