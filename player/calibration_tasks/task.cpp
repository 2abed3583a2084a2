#include "calibration_tasks/task.hpp"

#include "calibration_tasks/solve_part.hpp"
#include "core/error.hpp"
#include "settings/settings_text.hpp"

namespace vrda::calibration_tasks {

std::vector<Task> tasks_of(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                           const bench_files::Calibration& calibration)
{
  switch (part) {
    case bench_files::CalibrationPart::viewport:
      return viewport_tasks(bench);
    case bench_files::CalibrationPart::distortion:
      return distortion_tasks(bench, calibration);
    case bench_files::CalibrationPart::rails:
      return rail_tasks(bench);
    case bench_files::CalibrationPart::stop:
      return stop_tasks();
    case bench_files::CalibrationPart::probe:
      return probe_tasks(bench);
    case bench_files::CalibrationPart::eyepoints:
      return eyepoint_tasks(bench, calibration);
    case bench_files::CalibrationPart::ipd:
      return ipd_tasks(bench);
    case bench_files::CalibrationPart::subject:
      return subject_tasks(bench);
    case bench_files::CalibrationPart::bullseye:
    case bench_files::CalibrationPart::head:
      return bullseye_tasks(part, bench, calibration);
    case bench_files::CalibrationPart::leg:
    case bench_files::CalibrationPart::femur:
    case bench_files::CalibrationPart::tibia:
      return model_tasks(part, bench, calibration);
  }
  throw InternalError("every part has tasks");
}

TaskGroup task_group_of(bench_files::CalibrationPart part, const std::vector<Task>& tasks, std::size_t task)
{
  if (part == bench_files::CalibrationPart::rails) return {task, task + 1};
  TaskGroup round{0, tasks.size()};
  const bool is_by_eye = part == bench_files::CalibrationPart::viewport ||
                         part == bench_files::CalibrationPart::distortion ||
                         part == bench_files::CalibrationPart::eyepoints;
  if (!is_by_eye) return round;
  const auto is_same = [&](std::size_t k) { return tasks[k].is_right == tasks[task].is_right; };
  while (!is_same(round.begin)) ++round.begin;
  while (!is_same(round.end - 1)) --round.end;
  return round;
}

namespace {

/// Typical alignment noise of a line.
constexpr double usual_noise_px = 0.5;

std::string expected_eyepoint(const bench_files::BenchFile& bench,
                              const bench_files::Calibration& calibration)
{
  const calibration::Eyepoint usual{optics::Eye().distance_px, calibration.image_distance_mm};
  const Eigen::Vector2d sd =
      calibration::expected_eyepoint_sd(rectangles_of(bench.calibration), usual, usual_noise_px);
  return "Expected accuracy with these rectangles and half a pixel of noise: distance about +-" +
         settings::rounded_text(2.0 * sd.x(), 1) + " px, depth +-" + settings::rounded_text(2.0 * sd.y(), 1) +
         " mm. A larger range of depths improves it.";
}

}  // namespace

std::vector<std::string> intro_messages(bench_files::CalibrationPart part,
                                        const bench_files::BenchFile& bench,
                                        const bench_files::Calibration& calibration)
{
  if (part == bench_files::CalibrationPart::eyepoints) return {expected_eyepoint(bench, calibration)};
  return {};
}

std::vector<std::string> result_messages(bench_files::CalibrationPart part,
                                         const calibration::Estimate& estimate)
{
  std::vector<std::string> words{std::string(bench_files::name_of(part)) + " is done:"};
  const std::vector<std::string> lines = estimate_lines(estimate);
  words.insert(words.end(), lines.begin(), lines.end());
  return words;
}

}  // namespace vrda::calibration_tasks
