// Calibration tasks with the tracker: rails, stop, probe, marker positions, points of the model.
#include "calibration/task.hpp"

#include <array>

#include "calibration/parts.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

Task sweep_task(const char* name, const std::string& tool, int n_samples, const std::string& instruction)
{
  Task task;
  task.kind = TaskKind::sweep;
  task.name = name;
  task.tool = tool;
  task.n_samples = n_samples;
  task.instruction = instruction;
  return task;
}

std::string place_text(int index)
{
  static constexpr std::array<const char*, 3> across{"to the left", "in the middle", "to the right"};
  static constexpr std::array<const char*, 3> up{"low", "at eye level", "high"};
  static constexpr std::array<const char*, 3> depth{"near", "half way", "far"};
  const Eigen::Vector3i place = requested_marker_position(index);
  const auto word = [](const auto& words, int k) {
    return std::string(words[static_cast<std::size_t>(k + 1)]);
  };
  return word(depth, place.z()) + ", " + word(across, place.x()) + ", " + word(up, place.y());
}

Task bullseye_task(CalibrationPart part, const BenchFile& bench, const Calibration& calibration, int place,
                   bool is_right)
{
  constexpr double step_px = 0.25;
  const view::Eye& eye = view::side_of(calibration.eyes, is_right);
  Task task;
  task.kind = TaskKind::bullseye;
  task.is_right = is_right;
  task.index = place;
  task.tool = bench.calibration.marker;
  task.n_samples = bench.calibration.hold_samples;
  task.name = eye_text(is_right) + ", place " + std::to_string(place + 1);
  const bool is_head = part == CalibrationPart::head;
  task.instruction =
      std::string("Put the marker ") + place_text(place) +
      (is_head ? " and change the orientation of the head." : "; the stage may be at any position.") +
      "\nWith the " + eye_text(is_right) +
      ", align the cross with it and press Enter. Keep still until sampling is done.";
  const view::ShownBox box = view::shown_box(eye);
  const auto dial = [](const char* name, double value, double least, double most) {
    return Dial{
        .name = name, .unit = "px", .value = value, .minimum = least, .maximum = most, .step = step_px};
  };
  task.dials = {dial("x", eye.sight_px.x(), box.low_px.x(), box.high_px.x()),
                dial("y", eye.sight_px.y(), box.low_px.y(), box.high_px.y())};
  return task;
}

Task place_task(const char* model, const bench::PoseParameters& begin, int repeat)
{
  // Well below the scatter of a hand: otherwise equal rounded poses would seem exact.
  constexpr double most_mm = 10000.0, step_mm = 0.1, step_deg = 0.1;
  Task task;
  task.kind = TaskKind::model_pose;
  task.index = repeat;
  task.name = "place " + std::to_string(repeat + 1);
  task.instruction = std::string("Move and rotate the model of the ") + model +
                     " until it matches the real one;\nthen check from other positions and correct. "
                     "Up and Down select, Left and Right change.";
  const std::array<const char*, 3> axes{"x", "y", "z"};
  for (std::size_t k = 0; k < 3; ++k) {
    task.dials.push_back({.name = std::string("shift ") + axes[k],
                          .unit = "mm",
                          .value = begin.shift_mm[static_cast<Eigen::Index>(k)],
                          .minimum = -most_mm,
                          .maximum = most_mm,
                          .step = step_mm});
  }
  for (std::size_t k = 0; k < 3; ++k) {
    task.dials.push_back({.name = std::string("turn ") + axes[k],
                          .unit = "deg",
                          .value = deg_from_rad(begin.turn_rad[static_cast<Eigen::Index>(k)]),
                          .minimum = -360.0,
                          .maximum = 360.0,
                          .step = step_deg});
  }
  return task;
}

}  // namespace

Eigen::Vector3i requested_marker_position(int index)
{
  // The first four span all directions; corners come before the middles.
  static constexpr std::array<std::array<int, 3>, 27> places{
      {{-1, -1, -1}, {1, 1, -1},  {1, -1, 1},  {-1, 1, 1}, {0, 0, 0},  {1, -1, -1}, {-1, 1, -1},
       {-1, -1, 1},  {1, 1, 1},   {0, 0, -1},  {0, 0, 1},  {-1, 0, 0}, {1, 0, 0},   {0, -1, 0},
       {0, 1, 0},    {-1, 0, -1}, {1, 0, 1},   {-1, 0, 1}, {1, 0, -1}, {0, -1, -1}, {0, 1, 1},
       {0, -1, 1},   {0, 1, -1},  {-1, -1, 0}, {1, 1, 0},  {-1, 1, 0}, {1, -1, 0}}};
  const std::array<int, 3>& place = places[static_cast<std::size_t>(index) % places.size()];
  return {place[0], place[1], place[2]};
}

std::vector<Task> rail_tasks(const BenchFile& bench)
{
  const CalibrationSettings& settings = bench.calibration;
  const int n = settings.rail_samples;
  return {
      sweep_task(
          "x rail", settings.marker, n,
          "Attach the marker to the stage. Press Enter, then move the stage slowly along its whole rail,\n"
          "from left to right, with the marker visible to the tracker."),
      sweep_task(
          "z rail", settings.marker, n,
          "Attach the marker to the slide of the rail along the table. Press Enter, then move it slowly\n"
          "along the whole rail, towards the viewer.")};
}

std::vector<Task> stop_tasks()
{
  Task task;
  task.kind = TaskKind::stop;
  task.name = "stop";
  task.instruction = "Move the stage against its stop, hold it there and press Enter to zero it.";
  return {task};
}

std::vector<Task> probe_tasks(const BenchFile& bench)
{
  return {sweep_task(
      "sweep", bench.calibration.probe, bench.calibration.pivot_samples,
      "Put the probe's tip into a small hole. Press Enter, then tilt the probe forwards, backwards,\nto the "
      "left and to the right over a range of 40 degrees or more. The tip must not slip.")};
}

std::vector<Task> bullseye_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& calibration)
{
  std::vector<Task> tasks;
  for (int place = 0; place < bench.calibration.bullseyes; ++place) {
    for (const bool is_right : {false, true})
      tasks.push_back(bullseye_task(part, bench, calibration, place, is_right));
  }
  return tasks;
}

std::vector<Task> model_tasks(CalibrationPart part, const BenchFile& bench, const Calibration& calibration)
{
  const CalibrationSettings& settings = bench.calibration;
  std::vector<Task> tasks;
  if (settings.is_model_adjusted) {
    const bench::PoseParameters& begin = calibration.X_body_model[static_cast<std::size_t>(role_of(part))];
    for (int repeat = 0; repeat < settings.model_repeats; ++repeat)
      tasks.push_back(place_task(bench::name_of(part), begin, repeat));
    return tasks;
  }
  const std::vector<CalibrationPoint>& points = points_of(part, settings);
  for (std::size_t k = 0; k < points.size(); ++k) {
    Task task;
    task.kind = TaskKind::hold;
    task.name = points[k].name;
    task.index = static_cast<int>(k);
    task.tool = settings.probe;
    task.n_samples = settings.hold_samples;
    task.instruction = "Touch with the probe's tip: " + points[k].name +
                       (points[k].is_target ? " (target, not part of the fit).\n" : ".\n") +
                       "Press Enter and keep probe and leg still until sampling is done.";
    tasks.push_back(task);
  }
  return tasks;
}

std::vector<Task> bend_tasks(const BenchFile& bench)
{
  const std::optional<bench::BodySettings>& tibia = bench.bodies[static_cast<std::size_t>(BodyRole::tibia)];
  std::vector<Task> tasks;
  for (int bend = 0; bend < bench.calibration.bends; ++bend) {
    Task task;
    task.kind = TaskKind::bend;
    task.name = "bend " + std::to_string(bend + 1);
    task.index = bend;
    task.tool = tibia->tool.empty() ? tibia->markers.front() : tibia->tool;
    task.n_samples = bench.calibration.bend_samples;
    task.instruction =
        "Stretch the leg and press Enter. Bend it slowly as far as the model reaches and stretch it again, "
        "evenly\n"
        "until sampling is done, without pressing it sideways. Both bodies must be visible and must not "
        "slip.";
    tasks.push_back(task);
  }
  return tasks;
}

}  // namespace vrda::calibration
