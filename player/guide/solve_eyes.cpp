#include "guide/solve_part.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "guide/marks.hpp"
#include "guide/refusal.hpp"
#include "guide/task.hpp"

namespace vrda {
namespace {

std::vector<MarkedTask> tasks_of_eye(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                                     bool is_right)
{
  std::vector<MarkedTask> tasks = marked_tasks(part, bench, begun);
  std::erase_if(tasks, [&](const MarkedTask& t) { return t.task.is_right != is_right || t.mark == nullptr; });
  return tasks;
}

const Eye& side_of(const EyePair& eyes, bool is_right)
{
  return is_right ? eyes.right : eyes.left;
}

}  // namespace

std::vector<MarkedTask> marked_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& begun)
{
  const auto record = begun.records.find(part);
  std::vector<MarkedTask> marked;
  for (Task& task : tasks_of(part, bench, begun)) {
    const CalibrationMark* mark =
        record == begun.records.end() ? nullptr : mark_of(record->second, task.name);
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

ViewportFit viewport_of(const BenchFile& bench, const Calibration& begun, bool is_right,
                        const std::string& path)
{
  ViewportMarks marks;
  marks.screen_sd_mm = bench.calibration.screen_sd_mm;
  std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::viewport, bench, begun, is_right);
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
  const Viewport& window = is_right ? bench.display.windows.right : bench.display.windows.left;
  return fitted(names_of(tasks), [&] { return fit_viewport(marks, window, side_text(is_right), path); });
}

DistortionFit distortion_of(const BenchFile& bench, const Calibration& begun, bool is_right,
                            const std::string& path)
{
  const EyePair eyes = eyes_before(CalibrationPart::distortion, bench, begun);
  const std::string name = side_text(is_right);
  const Estimate& viewport = estimate_of(CalibrationPart::viewport, begun, path);
  const std::string aspect = name + ".pixel_aspect";
  const AspectPrior prior{value_in(viewport, aspect), std::sqrt(known_covariance(viewport, {aspect})(0, 0))};
  std::vector<GridMark> nodes;
  const CalibrationSettings& settings = bench.calibration;
  AdjustedGrids grids{{}, settings.grid_columns, settings.grid_rows};
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::distortion, bench, begun, is_right);
  for (const MarkedTask& t : tasks) {
    const std::vector<double>& v = t.mark->rows[0];
    if (t.task.kind == TaskKind::point) {
      nodes.push_back({t.task.node, {v[0], v[1]}});
    } else {
      grids.values.push_back({v[0], v[1], {v[2], v[3]}, {{v[4], v[5]}, v[6], v[7]}});
    }
  }
  const Eye& eye = side_of(eyes, is_right);
  return fitted(names_of(tasks), [&] {
    return settings.is_grid_adjusted ? mean_distortion(grids, eye, prior, name, path)
                                     : fit_distortion(nodes, eye, prior, name, path);
  });
}

std::vector<RectangleMark> rectangles_of(const CalibrationSettings& settings)
{
  std::vector<RectangleMark> marks;
  for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
    for (const CalibrationRectangle& r : settings.rectangles)
      marks.push_back({r.width_mm, r.depth_mm, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()});
  }
  return marks;
}

EyeRectangles eyepoint_of(const BenchFile& bench, const Calibration& begun, bool is_right,
                          const std::string& path)
{
  const CalibrationSettings& settings = bench.calibration;
  EyeRectangles found;
  found.eye = side_of(eyes_before(CalibrationPart::eyepoints, bench, begun), is_right);
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::eyepoints, bench, begun, is_right);
  for (const MarkedTask& t : tasks) {
    const CalibrationRectangle& r = settings.rectangles[static_cast<std::size_t>(t.task.index)];
    const std::vector<double>& v = t.mark->rows[0];
    found.marks.push_back({r.width_mm, r.depth_mm, {v[0], v[1]}, {v[2], v[3]}});
  }
  EyepointOptions options;
  options.alignment_sd_rad = rad_from_deg(settings.alignment_sd_deg);
  options.distortion_covariance =
      known_covariance(estimate_of(CalibrationPart::distortion, begun, path), distortion_names(is_right));
  found.fit = fitted(names_of(tasks), [&] {
    return fit_eyepoint(found.marks, found.eye, options, side_text(is_right), path);
  });
  return found;
}

}  // namespace vrda
