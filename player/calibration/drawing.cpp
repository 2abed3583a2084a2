#include "calibration/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/distortion_fit.hpp"
#include "calibration/session.hpp"
#include "calibration/task.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

constexpr double longest_piece_px = 8.0;
using Points2d = std::vector<Eigen::Vector2d>;

/// Limits the range of a segment to coordinates from `low` to `high`; false if it is outside.
bool clip(double at, double step, double low, double high, double& from, double& to)
{
  if (step == 0.0) return at >= low && at <= high;
  const double t1 = (low - at) / step, t2 = (high - at) / step;
  from = std::max(from, std::min(t1, t2));
  to = std::min(to, std::max(t1, t2));
  return from <= to;
}

}  // namespace

std::vector<Points2d> pieces_within(const Points2d& line, const view::ShownBox& box)
{
  std::vector<Points2d> pieces;
  bool is_continued = false;
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    double from = 0.0, to = 1.0;
    const Eigen::Vector2d a = line[k], step = line[k + 1] - a;
    const bool is_in = clip(a.x(), step.x(), box.low_px.x(), box.high_px.x(), from, to) &&
                       clip(a.y(), step.y(), box.low_px.y(), box.high_px.y(), from, to) && from < to;
    if (is_in && (!is_continued || from > 0.0)) pieces.push_back({a + from * step});
    if (is_in) pieces.back().emplace_back(a + to * step);
    is_continued = is_in && to >= 1.0;
  }
  return pieces;
}

namespace {

/// Adds lines for one eye, clipped at its visible part.
class Pen {
 public:
  Pen(const view::Eye& eye, bool is_right, std::vector<DrawnLine>& lines)
      : eye_(eye), is_right_(is_right), lines_(lines)
  {
  }

  /// Adds a line in frame buffer coordinates.
  void draw(const Points2d& points)
  {
    for (Points2d& piece : pieces_within(points, view::box_of(eye_.visible)))
      lines_.push_back({is_right_, std::move(piece), 1.5, true, {1.0F, 1.0F, 1.0F}});
  }

  /// Adds a straight line of the undistorted image, pre-distorted.
  void draw_shown(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
  {
    // Halves pieces that are too long after pre-distortion.
    Points2d drawn{view::drawn_px(eye_.distortion, from)};
    const int n = std::max(1, static_cast<int>(std::ceil((to - from).norm() / longest_piece_px)));
    for (int k = 0; k < n; ++k)
      add_piece(from + (to - from) * k / n, from + (to - from) * (k + 1) / n, drawn, 0);
    draw(drawn);
  }

 private:
  void add_piece(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Points2d& drawn, int depth) const
  {
    constexpr int deepest = 8;
    const Eigen::Vector2d end = view::drawn_px(eye_.distortion, to);
    if ((end - drawn.back()).norm() <= longest_piece_px || depth == deepest) {
      drawn.push_back(end);
      return;
    }
    const Eigen::Vector2d middle = 0.5 * (from + to);
    add_piece(from, middle, drawn, depth + 1);
    add_piece(middle, to, drawn, depth + 1);
  }

  const view::Eye& eye_;
  bool is_right_;
  std::vector<DrawnLine>& lines_;
};

DrawnLine scan_line(const view::Eye& eye, const Task& task, double at)
{
  const view::Viewport& w = eye.window;
  DrawnLine line;
  line.is_right = task.is_right;
  line.is_smooth = false;
  const double middle = at + 0.5;  // pixel centre
  if (task.is_column) {
    line.points_px = {{middle, w.y}, {middle, w.y + w.height}};
  } else {
    line.points_px = {{w.x, middle}, {w.x + w.width, middle}};
  }
  return line;
}

void draw_cross(Pen& pen, const Eigen::Vector2d& at)
{
  constexpr double arm_px = 8.0;
  pen.draw({at - Eigen::Vector2d(arm_px, 0.0), at + Eigen::Vector2d(arm_px, 0.0)});
  pen.draw({at - Eigen::Vector2d(0.0, arm_px), at + Eigen::Vector2d(0.0, arm_px)});
}

void draw_sides(Pen& pen, const view::Eye& eye, std::span<const double> x)
{
  const view::ShownBox box = view::shown_box(eye);
  for (const double side : x) pen.draw_shown({side, box.low_px.y()}, {side, box.high_px.y()});
}

/// Rings and a cross with an open centre, which does not hide the marker.
void draw_bullseye(Pen& pen, const Eigen::Vector2d& at)
{
  constexpr double open_px = 2.0, arm_px = 16.0;
  for (const Eigen::Vector2d& direction :
       {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0), Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1)})
    pen.draw_shown(at + open_px * direction, at + arm_px * direction);
  constexpr int n = 48;
  for (const double radius_px : {6.0, 12.0}) {
    const auto on_ring = [&](int k) {
      const double angle = 2.0 * std::numbers::pi * k / n;
      return Eigen::Vector2d(at + radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    };
    for (int k = 0; k < n; ++k) pen.draw_shown(on_ring(k), on_ring(k + 1));
  }
}

void draw_grid(std::vector<DrawnLine>& lines, const view::Eye& eye, const Task& task,
               std::span<const double> v)
{
  view::Eye dialled = eye;
  dialled.distortion.k1 = v[0];
  dialled.distortion.k2 = v[1];
  dialled.distortion.centre_px = {v[2], v[3]};
  const calibration::GridPose grid{{v[4], v[5]}, v[6], rad_from_deg(v[7])};
  Pen pen(dialled, task.is_right, lines);
  const Eigen::Vector2d corner = 0.5 * (task.node - Eigen::Vector2d::Ones());
  const auto shown = [&](double column, double row) {
    return calibration::shown_px(grid, eye.pixel_aspect, Eigen::Vector2d(column, row));
  };
  for (double x = -corner.x(); x <= corner.x(); x += 1.0)
    pen.draw_shown(shown(x, -corner.y()), shown(x, corner.y()));
  for (double y = -corner.y(); y <= corner.y(); y += 1.0)
    pen.draw_shown(shown(-corner.x(), y), shown(corner.x(), y));
}

void draw_look(std::vector<DrawnLine>& lines, const Calibration& calibration)
{
  const double half_mm = 0.5 * test_frame_size_mm, z_mm = -calibration.image_distance_mm;
  const std::array<Eigen::Vector3d, 4> corners{Eigen::Vector3d(-half_mm, -half_mm, z_mm),
                                               {half_mm, -half_mm, z_mm},
                                               {half_mm, half_mm, z_mm},
                                               {-half_mm, half_mm, z_mm}};
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = view::side_of(calibration.eyes, is_right);
    Pen pen(eye, is_right, lines);
    for (std::size_t k = 0; k < corners.size(); ++k)
      pen.draw_shown(view::shown_px(eye, corners[k]), view::shown_px(eye, corners[(k + 1) % corners.size()]));
  }
}

}  // namespace

std::vector<DrawnLine> task_lines(const Task& task, std::span<const double> values,
                                  const Calibration& calibration)
{
  check(values.size() == task.dials.size(), "a task has a value for each dial");
  const view::Eye& eye = view::side_of(calibration.eyes, task.is_right);
  std::vector<DrawnLine> lines;
  Pen pen(eye, task.is_right, lines);
  switch (task.kind) {
    case TaskKind::scan_line:
      lines.push_back(scan_line(eye, task, values[0]));
      break;
    case TaskKind::point:
      draw_cross(pen, {values[0], values[1]});
      break;
    case TaskKind::rectangle_sides:
      draw_sides(pen, eye, values);
      break;
    case TaskKind::grid:
      draw_grid(lines, eye, task, values);
      break;
    case TaskKind::bullseye:
      draw_bullseye(pen, {values[0], values[1]});
      break;
    case TaskKind::depth_check:
      draw_look(lines, calibration);
      break;
    case TaskKind::number:
    case TaskKind::sweep:
    case TaskKind::bend:
    case TaskKind::hold:
    case TaskKind::model_pose:
    case TaskKind::stop:
      break;
  }
  return lines;
}

std::vector<DrawnLine> task_lines(const CalibrationSession& session)
{
  if (session.task() == nullptr) return {};
  return task_lines(*session.task(), session.values(), session.drawing_calibration());
}

}  // namespace vrda::calibration
