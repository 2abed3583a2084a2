#include "virtual_bench/alignment.hpp"

#include <cmath>

#include "core/error.hpp"
#include "simulation/draws.hpp"

namespace vrda {
namespace {

/// The point of a side that the eye sees at the height `row_px`.
Eigen::Vector2d side_at_row(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& side_table_mm,
                            double row_px)
{
  // The row is a ratio of two linear functions of the height; one step of the secant between two points of
  // the side gives it exactly when the line is parallel to the screen, two more mend the rest.
  const auto seen = [&](double y_mm) -> Eigen::Vector2d {
    return seen_px(truth, is_right, {side_table_mm.x(), y_mm, side_table_mm.y()});
  };
  double before_mm = truth.calibration.X_table_eyes.shift_mm.y(), y_mm = before_mm + 10.0;
  double before_px = seen(before_mm).y();
  constexpr int most_steps = 8;
  for (int step = 0; step < most_steps; ++step) {
    const double at_px = seen(y_mm).y();
    if (at_px == before_px || at_px == row_px) break;
    const double next_mm = y_mm + (row_px - at_px) * (y_mm - before_mm) / (at_px - before_px);
    before_mm = y_mm;
    before_px = at_px;
    y_mm = next_mm;
  }
  return seen(y_mm);
}

}  // namespace

const Eye& eye_of(const EyePair& eyes, bool is_right)
{
  return is_right ? eyes.right : eyes.left;
}

Pose X_tracker_eyes(const Calibration& calibration, double stage_mm)
{
  Pose X_table_eyes = pose_of(calibration.X_table_eyes);
  X_table_eyes.translation() += stage_mm * calibration.stage_direction_table;
  return pose_of(calibration.X_tracker_table) * X_table_eyes;
}

RectangleSides rectangle_sides(const BenchFile& bench, const VirtualTruth& truth, std::size_t index)
{
  check(index < bench.calibration.rectangles.size(), "a rectangle of the bench file");
  const CalibrationRectangle& rectangle = bench.calibration.rectangles[index];
  // Put up by hand, a few millimetres beside the middle.
  constexpr std::uint64_t first = 1000;
  constexpr double off_sd_mm = 5.0;
  const double x_mm = truth.calibration.X_table_eyes.shift_mm.x() +
                      off_sd_mm * Draws(truth.seed, DrawFor::virtual_bench, first + index).normal();
  return {x_mm - 0.5 * rectangle.width_mm, x_mm + 0.5 * rectangle.width_mm,
          truth.reference_plane_table_mm - rectangle.depth_mm};
}

Eigen::Vector2d seen_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector3d& p_table_mm)
{
  const Eigen::Vector3d p_eyes_mm = pose_of(truth.calibration.X_table_eyes).inverse() * p_table_mm;
  return shown_px(eye_of(truth.calibration.eyes, is_right), p_eyes_mm);
}

double scan_reading(double border_px, bool is_last)
{
  return is_last ? std::floor(border_px - 0.5) : std::ceil(border_px - 0.5);
}

Eigen::Vector2d drawn_node_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& node)
{
  const Eye& eye = eye_of(truth.calibration.eyes, is_right);
  return drawn_px(eye.distortion, shown_px(truth.grids[is_right ? 1 : 0], eye.pixel_aspect, node));
}

double side_value(const SideLine& line, const VirtualTruth& truth, bool is_right,
                  const Eigen::Vector2d& side_table_mm, double off_px)
{
  const Distortion& drawing = line.drawing.distortion;
  const Distortion& optics = eye_of(truth.calibration.eyes, is_right).distortion;
  const auto drawn = [&](double value) -> Eigen::Vector2d { return drawn_px(drawing, {value, line.row_px}); };
  const auto ahead = [&](double value) {
    const Eigen::Vector2d at = shown_px(optics, drawn(value));
    return at.x() - side_at_row(truth, is_right, side_table_mm, at.y()).x();
  };
  constexpr double apart_px = 1.0, resolution_px = 1e-10;
  constexpr int most_steps = 30;
  double value = side_at_row(truth, is_right, side_table_mm, line.row_px).x();
  for (int step = 0; step < most_steps; ++step) {
    const double off = ahead(value);
    if (std::abs(off) < resolution_px) break;
    value -= 2.0 * apart_px * off / (ahead(value + apart_px) - ahead(value - apart_px));
  }
  const double wanted_px = drawn(value).x() + off_px;
  for (int step = 0; step < most_steps && std::abs(drawn(value).x() - wanted_px) > resolution_px; ++step) {
    const double slope = (drawn(value + apart_px).x() - drawn(value - apart_px).x()) / (2.0 * apart_px);
    value -= (drawn(value).x() - wanted_px) / slope;
  }
  return value;
}

Eigen::Vector2d cross_value(const Eye& drawing, const VirtualTruth& truth, bool is_right,
                            const Eigen::Vector2d& seen_px, const Eigen::Vector2d& off_px)
{
  const Distortion& optics = eye_of(truth.calibration.eyes, is_right).distortion;
  const Eigen::Vector2d wanted_px = drawn_px(optics, seen_px) + off_px;
  return shown_px(drawing.distortion, wanted_px);
}

}  // namespace vrda
