// Solves the calibration's parts of the display: edges, distortion, eye point.
#include "calibration/solve_part.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/marks.hpp"
#include "calibration/task.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

std::vector<MarkedTask> tasks_of_eye(CalibrationPart part, const PartInput& in, bool is_right)
{
  std::vector<MarkedTask> tasks = marked_tasks(part, in);
  std::erase_if(tasks, [&](const MarkedTask& t) { return t.task.is_right != is_right || t.mark == nullptr; });
  return tasks;
}

}  // namespace

std::vector<MarkedTask> marked_tasks(CalibrationPart part, const PartInput& in)
{
  const CalibrationRecord* record = find_record(in.begun, part);
  std::vector<MarkedTask> marked;
  for (Task& task : tasks_of(part, in.bench, in.begun)) {
    const CalibrationMark* mark = record == nullptr ? nullptr : find_mark(*record, task.name);
    marked.push_back({std::move(task), mark});
  }
  return marked;
}

std::vector<std::string> names_of(std::span<const MarkedTask> tasks)
{
  std::vector<std::string> names;
  for (const MarkedTask& t : tasks) names.push_back(t.task.name);
  return names;
}

bench::Estimate solve_viewport(const PartInput& in, bool is_right)
{
  calibration::ViewportMarks marks;
  marks.screen_sd_mm = in.bench.calibration.screen_sd_mm;
  std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::viewport, in, is_right);
  const auto order = [](const Task& task) {
    return std::pair(task.kind == TaskKind::scan_line ? 0 : 1, task.index);
  };
  std::stable_sort(tasks.begin(), tasks.end(),
                   [&](const MarkedTask& a, const MarkedTask& b) { return order(a.task) < order(b.task); });
  for (const MarkedTask& t : tasks) {
    const double number = t.mark->rows[0][0];
    if (t.task.kind == TaskKind::scan_line) {
      marks.line_px[static_cast<std::size_t>(t.task.index)].push_back(number);
    } else {
      marks.screen_mm[t.task.index] = number;
    }
  }
  const view::Viewport& window = view::side_of(in.bench.display.windows, is_right);
  return run_fit(names_of(tasks),
                 [&] { return calibration::fit_viewport(marks, window, side_name(is_right), in.path); });
}

calibration::DistortionFit solve_distortion(const PartInput& in, bool is_right)
{
  const view::EyePair eyes = eyes_before(CalibrationPart::distortion, in);
  const std::string name = side_name(is_right);
  const bench::Estimate& viewport = estimate_of(CalibrationPart::viewport, in);
  const std::string aspect = name + ".pixel_aspect";
  const calibration::AspectPrior prior{value_in(viewport, aspect),
                                       std::sqrt(prior_covariance(viewport, {aspect})(0, 0))};
  std::vector<calibration::GridMark> nodes;
  const CalibrationSettings& settings = in.bench.calibration;
  calibration::AdjustedGrids grids{{}, settings.grid_columns, settings.grid_rows};
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::distortion, in, is_right);
  for (const MarkedTask& t : tasks) {
    const std::vector<double>& v = t.mark->rows[0];
    if (t.task.kind == TaskKind::point) {
      nodes.push_back({t.task.node, {v[0], v[1]}});
    } else {
      grids.values.push_back({v[0], v[1], {v[2], v[3]}, {{v[4], v[5]}, v[6], v[7]}});
    }
  }
  const view::Eye& eye = view::side_of(eyes, is_right);
  return run_fit(names_of(tasks), [&] {
    return settings.is_grid_adjusted ? calibration::mean_distortion(grids, eye, prior, name, in.path)
                                     : calibration::fit_distortion(nodes, eye, prior, name, in.path);
  });
}

std::vector<calibration::RectangleMark> rectangles_of(const CalibrationSettings& settings)
{
  std::vector<calibration::RectangleMark> marks;
  for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
    for (const CalibrationRectangle& r : settings.rectangles)
      marks.push_back({r.width_mm, r.depth_mm, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()});
  }
  return marks;
}

calibration::EyeRectangles solve_eye_rectangles(const PartInput& in, bool is_right)
{
  const CalibrationSettings& settings = in.bench.calibration;
  calibration::EyeRectangles found;
  const view::EyePair eyes = eyes_before(CalibrationPart::eyepoints, in);
  found.eye = view::side_of(eyes, is_right);
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::eyepoints, in, is_right);
  for (const MarkedTask& t : tasks) {
    const CalibrationRectangle& r = settings.rectangles[static_cast<std::size_t>(t.task.index)];
    const std::vector<double>& v = t.mark->rows[0];
    found.marks.push_back({r.width_mm, r.depth_mm, {v[0], v[1]}, {v[2], v[3]}});
  }
  calibration::EyepointOptions options;
  options.alignment_sd_rad = settings.alignment_sd_rad;
  options.distortion_covariance =
      prior_covariance(estimate_of(CalibrationPart::distortion, in), distortion_names(is_right));
  found.fit = run_fit(names_of(tasks), [&] {
    return calibration::fit_eyepoint(found.marks, found.eye, options, side_name(is_right), in.path);
  });
  return found;
}

}  // namespace vrda::calibration
