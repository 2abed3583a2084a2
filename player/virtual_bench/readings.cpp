#include "virtual_bench/readings.hpp"

#include "calibration/distortion_fit.hpp"
#include "calibration/viewport_fit.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "tracking/screw.hpp"
#include "virtual_bench/alignment.hpp"
#include "virtual_bench/standing.hpp"

namespace vrda {
namespace {

Eigen::Vector2d off_px(const VirtualNoise& noise, Draws& draws)
{
  const double x = draws.normal(), y = draws.normal();
  return noise.alignment_px * Eigen::Vector2d(x, y);
}

std::vector<double> scan(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                         Draws& draws)
{
  const VirtualTruth::Edges& edges = truth.edges_px[asked.task.is_right ? 1 : 0];
  const auto edge = static_cast<Edge>(asked.task.index);
  const double border_px = edge == Edge::left    ? edges.left
                           : edge == Edge::right ? edges.right
                           : edge == Edge::top   ? edges.top
                                                 : edges.bottom;
  const bool is_last = edge == Edge::right || edge == Edge::bottom;
  return {scan_reading(border_px + noise.alignment_px * draws.normal(), is_last)};
}

std::vector<double> node(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                         Draws& draws)
{
  const Eigen::Vector2d at =
      drawn_node_px(truth, asked.task.is_right, asked.task.node) + off_px(noise, draws);
  return {at.x(), at.y()};
}

std::vector<double> sides(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                          const VirtualNoise& noise, Draws& draws)
{
  const RectangleSides rectangle = rectangle_sides(bench, truth, static_cast<std::size_t>(asked.task.index));
  SideLine line;
  line.drawing = eye_of(asked.found.eyes, asked.task.is_right);
  line.row_px = line.drawing.sight_px.y();
  std::vector<double> values;
  for (const double x_mm : {rectangle.left_table_mm, rectangle.right_table_mm}) {
    values.push_back(side_value(line, truth, asked.task.is_right, {x_mm, rectangle.z_table_mm},
                                noise.alignment_px * draws.normal()));
  }
  return values;
}

/// Somebody who matches all nodes as well as eight numbers can, each node with the noise of an alignment.
std::vector<double> whole_grid(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                               const VirtualNoise& noise, Draws& draws)
{
  std::vector<GridMark> marks;
  for (int row = 0; row < bench.calibration.grid_rows; ++row) {
    for (int column = 0; column < bench.calibration.grid_columns; ++column) {
      const Eigen::Vector2d at(column - 0.5 * (bench.calibration.grid_columns - 1),
                               row - 0.5 * (bench.calibration.grid_rows - 1));
      marks.push_back({at, drawn_node_px(truth, asked.task.is_right, at) + off_px(noise, draws)});
    }
  }
  const Eye& drawing = eye_of(asked.found.eyes, asked.task.is_right);
  constexpr double held = 1e-6;
  const DistortionFit fit =
      fit_distortion(marks, drawing, {drawing.pixel_aspect, held}, "grid", "virtual bench");
  return {fit.distortion.k1,
          fit.distortion.k2,
          fit.distortion.centre_px.x(),
          fit.distortion.centre_px.y(),
          fit.grid.at_px.x(),
          fit.grid.at_px.y(),
          fit.grid.spacing_px,
          fit.grid.turn_rad / rad_from_deg(1.0)};
}

std::vector<double> bullseye(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                             const VirtualNoise& noise, Draws& draws)
{
  const Standing standing = at_bullseye(bench, truth, asked.task.index);
  const Eigen::Vector2d seen =
      shown_px(eye_of(truth.calibration.eyes, asked.task.is_right),
               standing.X_tracker_eyes.inverse() * standing.X_tracker_tool.translation());
  const Eigen::Vector2d value = cross_value(eye_of(asked.found.eyes, asked.task.is_right), truth,
                                            asked.task.is_right, seen, off_px(noise, draws));
  return {value.x(), value.y()};
}

/// Somebody who puts the model onto the leg to within an alignment of the marks 100 mm around, at 800 mm.
std::vector<double> place(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                          Draws& draws)
{
  constexpr double distance_mm = 800.0, distance_px = 880.0, about_mm = 100.0;
  const BodyRole role = asked.part == CalibrationPart::leg     ? BodyRole::leg
                        : asked.part == CalibrationPart::femur ? BodyRole::femur
                                                               : BodyRole::tibia;
  const double noise_mm = noise.alignment_px * distance_mm / distance_px;
  Pose X = pose_of(truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
  X.translation() += noise_mm * draws.normal_vector();
  X.linear() = rotation_of(noise_mm / about_mm * draws.normal_vector()) * X.linear();
  const SixNumbers six = six_numbers_of(X);
  std::vector<double> values(six.shift_mm.begin(), six.shift_mm.end());
  for (const double turn_rad : six.turn_rad) values.push_back(turn_rad / rad_from_deg(1.0));
  return values;
}

double size_of_screen(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                      Draws& draws)
{
  return truth.screen_mm[asked.task.is_right ? 1 : 0][asked.task.index] + noise.ruler_mm * draws.normal();
}

double number_of_person(const AskedFor& asked, const VirtualTruth& truth, const VirtualNoise& noise,
                        Draws& draws)
{
  enum Asked { pupils, left_arm, right_arm, image };
  const EyePair& eyes = truth.calibration.eyes;
  switch (asked.task.index) {
    case pupils:
      return eyes.right.position_head_mm.x() - eyes.left.position_head_mm.x() +
             noise.pupillometer_mm * draws.normal();
    case left_arm:
      return -eyes.left.position_head_mm.x();
    case right_arm:
      return eyes.right.position_head_mm.x();
    default:
      check(asked.task.index == image, "every number that is asked for can be read off");
      return truth.calibration.image_distance_mm;
  }
}

}  // namespace

std::optional<double> number_read(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                  const VirtualNoise& noise, Draws& draws)
{
  if (asked.task.kind != TaskKind::number) return std::nullopt;
  if (asked.part == CalibrationPart::viewport) return size_of_screen(asked, truth, noise, draws);
  if (asked.part != CalibrationPart::subject) return number_of_person(asked, truth, noise, draws);
  const CalibrationLandmarks& pair =
      bench.calibration.landmarks.at(static_cast<std::size_t>(asked.task.index));
  return truth.calibration.subject_scale * pair.model_mm + noise.landmark_mm * draws.normal();
}

std::vector<double> dial_values(const AskedFor& asked, const BenchFile& bench, const VirtualTruth& truth,
                                const VirtualNoise& noise, Draws& draws)
{
  switch (asked.task.kind) {
    case TaskKind::scan_line:
      return scan(asked, truth, noise, draws);
    case TaskKind::point:
      return node(asked, truth, noise, draws);
    case TaskKind::sides:
      return sides(asked, bench, truth, noise, draws);
    case TaskKind::grid:
      return whole_grid(asked, bench, truth, noise, draws);
    case TaskKind::number:
      return {number_read(asked, bench, truth, noise, draws).value()};
    case TaskKind::bullseye:
      return bullseye(asked, bench, truth, noise, draws);
    case TaskKind::place:
      return place(asked, truth, noise, draws);
    case TaskKind::sweep:
    case TaskKind::hold:
    case TaskKind::stop:
    case TaskKind::look:
      break;
  }
  return {};
}

}  // namespace vrda
