/// One thing that the operator is asked to do.
#pragma once

#include <span>
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

}  // namespace vrda
