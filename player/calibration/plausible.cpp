#include "calibration/plausible.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/solve_part.hpp"
#include "show/settings_text.hpp"

namespace vrda::calibration {
namespace {

std::string with_unit(double value, const std::string& unit)
{
  return show::rounded_text(value, 2) + (unit.empty() ? "" : " " + unit);
}

std::string thing_of(TaskKind kind)
{
  switch (kind) {
    case TaskKind::scan_line:
      return "line";
    case TaskKind::rectangle_sides:
      return "lines";
    case TaskKind::point:
    case TaskKind::bullseye:
      return "cross";
    case TaskKind::grid:
      return "grid";
    case TaskKind::model_pose:
      return "model";
    default:
      return "number";
  }
}

/// Where the tool of a static measurement was, in the body's frame; empty for other kinds.
std::vector<Eigen::Vector3d> places_of(const Task& task, const CalibrationMark& mark)
{
  if (task.kind == TaskKind::bullseye) return marker_positions(mark);
  std::vector<Eigen::Vector3d> places;
  if (task.kind != TaskKind::hold) return places;
  for (const std::vector<double>& row : mark.rows)
    places.push_back(sampled_pose(row, 7).inverse() * sampled_position(row));
  return places;
}

}  // namespace

std::string untouched_text(const Task& task, const std::vector<bool>& touched)
{
  if (task.dials.empty() || task.is_start_valid) return {};
  const bool is_done = task.kind == TaskKind::rectangle_sides ? std::ranges::all_of(touched, std::identity())
                                                              : std::ranges::any_of(touched, std::identity());
  if (is_done) return {};
  const bool is_part = std::ranges::any_of(touched, std::identity());
  const std::string thing = is_part ? "other line" : thing_of(task.kind);
  const bool is_plural = !is_part && task.kind == TaskKind::rectangle_sides;
  return "Not taken: the " + thing + (is_plural ? " were" : " was") +
         " not touched. Follow the instruction above, then press Enter. If the " + thing +
         (is_plural ? " are right where they are, move each" : " is right where it is, move it") +
         " by a step and back first.";
}

std::string implausible_text(const Task& task, std::span<const double> values)
{
  for (std::size_t k = 0; k < task.dials.size(); ++k) {
    const Dial& dial = task.dials[k];
    if (values[k] >= dial.least_plausible && values[k] <= dial.most_plausible) continue;
    return "Not taken: " + dial.name + " " + with_unit(values[k], dial.unit) +
           " is implausible, expected is " + with_unit(dial.least_plausible, "") + " to " +
           with_unit(dial.most_plausible, dial.unit) +
           ". Read again and correct it. If it is right, press Enter again.";
  }
  return {};
}

std::string same_place_text(const std::vector<Task>& tasks, const CalibrationRecord& record, const Task& task,
                            const CalibrationMark& mark)
{
  constexpr double same_mm = 1.0;  // above the noise of a mean, below the distance of two points
  const std::vector<Eigen::Vector3d> places = places_of(task, mark);
  if (places.empty()) return {};
  const Eigen::Vector3d p_mm = mean_position(places).p_mm;
  for (const Task& other : tasks) {
    // Both eyes look at one marker position.
    const CalibrationMark* const done = other.index == task.index ? nullptr : find_mark(record, other.name);
    if (done == nullptr || (mean_position(places_of(other, *done)).p_mm - p_mm).norm() > same_mm) continue;
    return "Not taken: " + task.tool + " is where it was for \"" + other.name +
           "\". Move it as the instruction above says, then press Enter.";
  }
  return {};
}

std::string unexpected_text(const std::vector<Task>& tasks, const CalibrationRecord& record,
                            const bench::Estimate& estimate, const Calibration& nominal)
{
  const std::string again =
      ". The readings agree with each other, so they must be measured again: check the instrument, its unit "
      "and what is measured. The same readings are then accepted.";
  for (const Task& task : tasks) {
    const CalibrationMark* const mark = find_mark(record, task.name);
    const bool has_reading = task.kind == TaskKind::scan_line || task.kind == TaskKind::number;
    if (!has_reading || mark == nullptr || implausible_text(task, mark->rows[0]).empty()) continue;
    return task.name + ": " + with_unit(mark->rows[0][0], task.dials[0].unit) + " is far from the expected " +
           with_unit(task.dials[0].least_plausible, "") + " to " +
           with_unit(task.dials[0].most_plausible, task.dials[0].unit) + again;
  }
  struct Expected {
    const char* name;
    double least, most;
  };
  const double eye_px = nominal.eyes.left.distance_px, image_mm = nominal.image_distance_mm;
  // Adults are 0.75 to 1.3 times as large as a reference body; displays and rectangles are built near their
  // nominal sizes, and square pixels are usual.
  const std::array<Expected, 8> expected{{{"subject.scale", 0.75, 1.35},
                                          {"ipd", 45.0, 80.0},
                                          {"left.distance", 0.5 * eye_px, 2.0 * eye_px},
                                          {"right.distance", 0.5 * eye_px, 2.0 * eye_px},
                                          {"left.depth", 0.3 * image_mm, 3.0 * image_mm},
                                          {"right.depth", 0.3 * image_mm, 3.0 * image_mm},
                                          {"left.pixel_aspect", 0.7, 1.4},
                                          {"right.pixel_aspect", 0.7, 1.4}}};
  for (const Expected& e : expected) {
    const auto found = std::ranges::find(estimate.names, e.name);
    if (found == estimate.names.end()) continue;
    const auto k = static_cast<std::size_t>(found - estimate.names.begin());
    const double value = estimate.values[static_cast<Eigen::Index>(k)];
    if (value >= e.least && value <= e.most) continue;
    return std::string(e.name) + " " + with_unit(value, estimate.units[k]) + " is far from the expected " +
           with_unit(e.least, "") + " to " + with_unit(e.most, estimate.units[k]) + again;
  }
  return {};
}

}  // namespace vrda::calibration
