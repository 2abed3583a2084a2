#include "calibration_tasks/solve_part.hpp"

#include <algorithm>
#include <cmath>

#include "calibration_tasks/marks.hpp"
#include "calibration_tasks/refusal.hpp"
#include "calibration_tasks/task.hpp"
#include "core/units.hpp"

namespace vrda::calibration_tasks {
namespace {

std::vector<MarkedTask> tasks_of_eye(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                     const bench_files::Calibration& begun, bool is_right)
{
  std::vector<MarkedTask> tasks = marked_tasks(part, bench, begun);
  std::erase_if(tasks, [&](const MarkedTask& t) { return t.task.is_right != is_right || t.mark == nullptr; });
  return tasks;
}

const optics::Eye& side_of(const optics::EyePair& eyes, bool is_right)
{
  return is_right ? eyes.right : eyes.left;
}

}  // namespace

std::vector<MarkedTask> marked_tasks(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                     const bench_files::Calibration& begun)
{
  const auto record = begun.records.find(part);
  std::vector<MarkedTask> marked;
  for (Task& task : tasks_of(part, bench, begun)) {
    const bench_files::CalibrationMark* mark =
        record == begun.records.end() ? nullptr : find_mark(record->second, task.name);
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

calibration::ViewportFit solve_viewport(const bench_files::BenchFile& bench,
                                        const bench_files::Calibration& begun, bool is_right,
                                        const std::string& path)
{
  calibration::ViewportMarks marks;
  marks.screen_sd_mm = bench.calibration.screen_sd_mm;
  std::vector<MarkedTask> tasks =
      tasks_of_eye(bench_files::CalibrationPart::viewport, bench, begun, is_right);
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
  const optics::Viewport& window = is_right ? bench.display.windows.right : bench.display.windows.left;
  return run_fit(names_of(tasks),
                 [&] { return calibration::fit_viewport(marks, window, side_name(is_right), path); });
}

calibration::DistortionFit solve_distortion(const bench_files::BenchFile& bench,
                                            const bench_files::Calibration& begun, bool is_right,
                                            const std::string& path)
{
  const optics::EyePair eyes = eyes_before(bench_files::CalibrationPart::distortion, bench, begun);
  const std::string name = side_name(is_right);
  const calibration::Estimate& viewport = estimate_of(bench_files::CalibrationPart::viewport, begun, path);
  const std::string aspect = name + ".pixel_aspect";
  const calibration::AspectPrior prior{value_in(viewport, aspect),
                                       std::sqrt(prior_covariance(viewport, {aspect})(0, 0))};
  std::vector<calibration::GridMark> nodes;
  const bench_files::CalibrationSettings& settings = bench.calibration;
  calibration::AdjustedGrids grids{{}, settings.grid_columns, settings.grid_rows};
  const std::vector<MarkedTask> tasks =
      tasks_of_eye(bench_files::CalibrationPart::distortion, bench, begun, is_right);
  for (const MarkedTask& t : tasks) {
    const std::vector<double>& v = t.mark->rows[0];
    if (t.task.kind == TaskKind::point) {
      nodes.push_back({t.task.node, {v[0], v[1]}});
    } else {
      grids.values.push_back({v[0], v[1], {v[2], v[3]}, {{v[4], v[5]}, v[6], v[7]}});
    }
  }
  const optics::Eye& eye = side_of(eyes, is_right);
  return run_fit(names_of(tasks), [&] {
    return settings.is_grid_adjusted ? calibration::mean_distortion(grids, eye, prior, name, path)
                                     : calibration::fit_distortion(nodes, eye, prior, name, path);
  });
}

std::vector<calibration::RectangleMark> rectangles_of(const bench_files::CalibrationSettings& settings)
{
  std::vector<calibration::RectangleMark> marks;
  for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
    for (const bench_files::CalibrationRectangle& r : settings.rectangles)
      marks.push_back({r.width_mm, r.depth_mm, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()});
  }
  return marks;
}

calibration::EyeRectangles solve_eye_rectangles(const bench_files::BenchFile& bench,
                                                const bench_files::Calibration& begun, bool is_right,
                                                const std::string& path)
{
  const bench_files::CalibrationSettings& settings = bench.calibration;
  calibration::EyeRectangles found;
  found.eye = side_of(eyes_before(bench_files::CalibrationPart::eyepoints, bench, begun), is_right);
  const std::vector<MarkedTask> tasks =
      tasks_of_eye(bench_files::CalibrationPart::eyepoints, bench, begun, is_right);
  for (const MarkedTask& t : tasks) {
    const bench_files::CalibrationRectangle& r = settings.rectangles[static_cast<std::size_t>(t.task.index)];
    const std::vector<double>& v = t.mark->rows[0];
    found.marks.push_back({r.width_mm, r.depth_mm, {v[0], v[1]}, {v[2], v[3]}});
  }
  calibration::EyepointOptions options;
  options.alignment_sd_rad = rad_from_deg(settings.alignment_sd_deg);
  options.distortion_covariance = prior_covariance(
      estimate_of(bench_files::CalibrationPart::distortion, begun, path), distortion_names(is_right));
  found.fit = run_fit(names_of(tasks), [&] {
    return calibration::fit_eyepoint(found.marks, found.eye, options, side_name(is_right), path);
  });
  return found;
}

}  // namespace vrda::calibration_tasks
