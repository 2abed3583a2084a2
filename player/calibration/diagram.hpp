/// Diagram of a calibration task for the operator: what is set up, what is moved, and the point that is next.
/// Coordinates from 0 to 1, x right, y down.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/calibrate.hpp"
#include "model/mesh.hpp"

namespace vrda::calibration {

enum class DiagramInk {
  plain,  ///< surroundings
  real,   ///< the physical thing of the task
  lit     ///< what the operator moves or touches
};

struct DiagramLine {
  std::vector<Eigen::Vector2d> points;  ///< two or more
  DiagramInk ink = DiagramInk::plain;
};

struct DiagramLabel {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< left, top
  std::string text;
};

struct Diagram {
  std::vector<DiagramLine> lines;
  std::vector<DiagramLabel> labels;
  double height = 0.6;  ///< of the used part, relative to the width
};

/// Outline of a body: edges between a front and a back face, from the front (right to left, up) and from the
/// subject's right (anterior, up); two points per piece, mm, canonical axes, y up.
struct BodyOutline {
  std::array<std::vector<std::array<Eigen::Vector2d, 2>>, 2> pieces;
};
BodyOutline outline_of(const Body& body);

/// `outline`: of the body that carries the points of a task that touches them; may be null.
Diagram diagram_of(CalibrationPart part, const Task& task, const BenchFile& bench,
                   const BodyOutline* outline);

}  // namespace vrda::calibration
