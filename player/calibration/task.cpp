#include "calibration/task.hpp"

#include "calibration/solve_part.hpp"
#include "core/text.hpp"
#include "show/session.hpp"

namespace vrda::calibration {

std::vector<Task> tasks_of(CalibrationPart part, const BenchFile& bench, const Calibration& calibration)
{
  switch (part) {
    case CalibrationPart::viewport:
      return viewport_tasks(bench);
    case CalibrationPart::distortion:
      return distortion_tasks(bench, calibration);
    case CalibrationPart::rails:
      return rail_tasks(bench);
    case CalibrationPart::stop:
      return stop_tasks();
    case CalibrationPart::probe:
      return probe_tasks(bench);
    case CalibrationPart::eyepoints:
      return eyepoint_tasks(bench, calibration);
    case CalibrationPart::ipd:
      return ipd_tasks(bench);
    case CalibrationPart::subject:
      return subject_tasks(bench);
    case CalibrationPart::bullseye:
    case CalibrationPart::head:
      return bullseye_tasks(part, bench, calibration);
    case CalibrationPart::leg:
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      return model_tasks(part, bench, calibration);
    case CalibrationPart::functional:
      return bend_tasks(bench);
  }
  throw InternalError("every part has tasks");
}

TaskGroup task_group_of(CalibrationPart part, const std::vector<Task>& tasks, std::size_t task)
{
  if (part == CalibrationPart::rails || part == CalibrationPart::functional) return {task, task + 1};
  TaskGroup round{0, tasks.size()};
  const bool is_by_eye = part == CalibrationPart::viewport || part == CalibrationPart::distortion ||
                         part == CalibrationPart::eyepoints;
  if (!is_by_eye) return round;
  const auto is_same = [&](std::size_t k) { return tasks[k].is_right == tasks[task].is_right; };
  while (!is_same(round.begin)) ++round.begin;
  while (!is_same(round.end - 1)) --round.end;
  return round;
}

std::string expected_eyepoint(const BenchFile& bench, const Calibration& calibration)
{
  constexpr double usual_noise_px = 0.5;  // of aligning a line
  const calibration::Eyepoint usual{view::Eye().distance_px, calibration.image_distance_mm};
  const Eigen::Vector2d sd =
      calibration::expected_eyepoint_sd(rectangles_of(bench.calibration), usual, usual_noise_px);
  return "Expected accuracy with these rectangles and half a pixel of noise: distance about +-" +
         show::rounded_text(2.0 * sd.x(), 1) + " px, depth +-" + show::rounded_text(2.0 * sd.y(), 1) +
         " mm. A larger range of depths improves it.";
}

}  // namespace vrda::calibration
