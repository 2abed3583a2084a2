/// Lines that tasks draw in the frame buffer, and sketches of tasks for the operator's area.
#pragma once

#include "calibration/task.hpp"

namespace vrda::calibration {

using Points2d = std::vector<Eigen::Vector2d>;

struct DrawnLine {
  bool is_right = false;  ///< window of the right eye
  Points2d points_px;     ///< frame buffer, pre-distorted; two or more
  double width_px = 1.0;
  bool is_smooth = true;  ///< anti-aliased; false: whole pixels
  std::array<float, 3> colour = {1.0F, 1.0F, 1.0F};
};

/// The parts of a line inside a box. Source: Liang, Barsky (1984) ACM Trans Graph 3:1-22.
std::vector<Points2d> pieces_within(const Points2d& line, const view::ShownBox& box);

/// The line with points at most 8 px apart: lines that are straight for the computer are curved for the eye.
Points2d with_points_between(const Points2d& line);

/// A closed ring of straight pieces.
Points2d ring(const Eigen::Vector2d& middle_px, double radius_px, int n_pieces = 24);

/// Corners of a rectangle, the first one again at the end.
Points2d rectangle_points(const Eigen::Vector2d& low, const Eigen::Vector2d& high);

/// The whole pixels nearest to a box.
view::Viewport nearest_pixels(const view::ShownBox& box);

/// Outline of a physical thing, in its colour.
DrawnLine real_outline(bool is_right, Points2d points_px);

/// Lines for one eye, clipped at its visible part.
class Pen {
 public:
  /// `eye` and `lines` must outlive the pen.
  Pen(const view::Eye& eye, bool is_right, std::vector<DrawnLine>& lines)
      : eye_(eye), is_right_(is_right), lines_(lines)
  {
  }
  /// Adds a line in frame buffer coordinates.
  void draw(const Points2d& points);
  /// Adds a straight line of the undistorted image, pre-distorted.
  void draw_shown(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

 private:
  void add_piece(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Points2d& drawn, int depth) const;

  const view::Eye& eye_;
  bool is_right_;
  std::vector<DrawnLine>& lines_;
};

// Diagram of a task for the operator: what is set up, what is moved, and the point that is next. Coordinates
// from 0 to 1, x right, y down.

enum class DiagramInk {
  plain,  ///< surroundings
  real,   ///< the physical thing of the task
  lit     ///< what the operator moves or touches
};

struct DiagramLine {
  Points2d points;  ///< two or more
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

/// Draws a diagram.
struct Sketch {
  void line(DiagramInk ink, Points2d points) { drawn.lines.push_back({std::move(points), ink}); }
  void box(DiagramInk ink, const Eigen::Vector2d& low, const Eigen::Vector2d& high)
  {
    line(ink, rectangle_points(low, high));
  }
  void circle(DiagramInk ink, const Eigen::Vector2d& middle, double radius);
  void arrow(DiagramInk ink, const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  void label(const Eigen::Vector2d& at, std::string text) { drawn.labels.push_back({at, std::move(text)}); }
  /// Both eyes from above, looking towards smaller y, `apart` from the middle `x`.
  void eyes(double x, double apart, DiagramInk left = DiagramInk::plain,
            DiagramInk right = DiagramInk::plain);

  /// Of the body that carries the points of the task; may be null.
  const BodyOutline* outline = nullptr;
  Diagram drawn;
};

/// `outline`: of the body that carries the points of the task; may be null.
Diagram diagram_of(const Task& task, const BenchFile& bench, const BodyOutline* outline);

}  // namespace vrda::calibration
