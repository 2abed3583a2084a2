#include "calibration/marks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/devices.hpp"
#include "bench/rigid_body.hpp"
#include "calibration/parts.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

/// A position is the cross, then a row a sample with or without the head's pose; a sweep has the stage in
/// each row or not; other samples are two poses; everything else is one row.
bool is_of_shape(const CalibrationMark& mark, const TaskKind::Traits& kind)
{
  using Samples = TaskKind::Samples;
  const auto n = [&](std::size_t k) { return mark.rows[k].size(); };
  const auto all = [&](std::size_t first, std::size_t one, std::size_t other) {
    return std::all_of(
        mark.rows.begin() + static_cast<std::ptrdiff_t>(first), mark.rows.end(),
        [&](const std::vector<double>& row) { return row.size() == one || row.size() == other; });
  };
  if (mark.rows.empty()) return false;
  switch (kind.samples) {
    case Samples::none:
      return mark.rows.size() == 1 && n(0) == kind.n_numbers;
    case Samples::sweep:
      return all(0, 7, 8);
    case Samples::hold:
    case Samples::leg:
      return all(0, 14, 14);
    case Samples::position:
      return mark.rows.size() > 1 && n(0) == kind.n_numbers && all(1, 3, 10);
  }
  return false;
}

std::ptrdiff_t index_of_task(const std::vector<Task>& tasks, const std::string& name)
{
  const auto found = std::ranges::find(tasks, name, &Task::name);
  return found - tasks.begin();
}

/// Root mean square distance from the mean of white noise with these differences of successive positions.
/// Source: von Neumann (1941) Ann Math Statist 12:367-395.
double successive_noise_mm(const std::vector<Eigen::Vector3d>& places)
{
  double sum_sq = 0.0;
  for (std::size_t k = 1; k < places.size(); ++k) sum_sq += (places[k] - places[k - 1]).squaredNorm();
  return places.size() < 2 ? 0.0 : std::sqrt(0.5 * sum_sq / static_cast<double>(places.size() - 1));
}

/// "0.5 to 2 mm"
std::string range_text(double least, double most, const std::string& unit)
{
  return short_decimal(least, 2) + " to " + bench::text(most, 2, unit);
}

}  // namespace

const CalibrationMark* find_mark(const CalibrationRecord& record, const std::string& task)
{
  const auto found = std::ranges::find(record.marks, task, &CalibrationMark::task);
  return found == record.marks.end() ? nullptr : &*found;
}

std::size_t next_task(const std::vector<Task>& tasks, const CalibrationRecord& record)
{
  std::size_t at = 0;
  while (at < tasks.size() && find_mark(record, tasks[at].name) != nullptr) ++at;
  return at;
}

void insert_mark(CalibrationRecord& record, const std::vector<Task>& tasks, CalibrationMark mark)
{
  std::erase_if(record.marks, [&](const CalibrationMark& m) { return m.task == mark.task; });
  const std::ptrdiff_t at = index_of_task(tasks, mark.task);
  const auto later = std::ranges::find_if(
      record.marks, [&](const CalibrationMark& m) { return index_of_task(tasks, m.task) > at; });
  record.marks.insert(later, std::move(mark));
}

void require_task_marks(const CalibrationRecord& record, const std::vector<Task>& tasks,
                        const std::string& place, const std::string& path)
{
  for (const CalibrationMark& mark : record.marks) {
    const auto at = static_cast<std::size_t>(index_of_task(tasks, mark.task));
    if (at == tasks.size()) {
      throw InputError({path, place, "a mark of '" + mark.task + "', which is not a task of the bench file",
                        "marks of its tasks; if [calibration] has changed, repeat the part with --anew"});
    }
    if (!is_of_shape(mark, tasks[at].kind->traits())) {
      throw InputError({path, place, "rows of '" + mark.task + "' with a wrong number of values",
                        "rows as in schemas/calibration.md; repeat the part with --anew"});
    }
  }
}

Pose sampled_pose(std::span<const double> row, std::size_t at)
{
  bench::ToolPose place;
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(at), 3, place.position_mm);
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(at) + 3, 4, place.rotation);
  return bench::pose_of(place);
}

Eigen::Vector3d sampled_position(std::span<const double> row)
{
  return {row[0], row[1], row[2]};
}

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

std::vector<MarkedTask> tasks_of_eye(CalibrationPart part, const PartInput& in, bool is_right)
{
  std::vector<MarkedTask> tasks = marked_tasks(part, in);
  std::erase_if(tasks, [&](const MarkedTask& t) { return t.task.is_right != is_right || t.mark == nullptr; });
  return tasks;
}

std::vector<std::string> names_of(std::span<const MarkedTask> tasks)
{
  std::vector<std::string> names;
  for (const MarkedTask& t : tasks) names.push_back(t.task.name);
  return names;
}

const CalibrationMark& mark_named(CalibrationPart part, const PartInput& in, const std::string& task)
{
  const CalibrationMark* mark = find_mark(in.begun.records.at(part), task);
  check(mark != nullptr, "a part is solved when all its tasks are done");
  return *mark;
}

view::EyePair eyes_before(CalibrationPart id, const PartInput& in)
{
  view::EyePair eyes = bench::nominal_calibration(in.bench).eyes;
  for (const auto& [earlier, record] : in.begun.records) {
    if (earlier < id && record.estimate) part_object(earlier).apply(eyes, *record.estimate);
  }
  return eyes;
}

const CalibrationRecord* find_record(const Calibration& calibration, CalibrationPart part)
{
  const auto found = calibration.records.find(part);
  return found == calibration.records.end() ? nullptr : &found->second;
}

const Estimate* find_estimate(const Calibration& calibration, CalibrationPart part)
{
  const CalibrationRecord* record = find_record(calibration, part);
  return record == nullptr || !record->estimate ? nullptr : &*record->estimate;
}

const Estimate& estimate_of(CalibrationPart part, const PartInput& in)
{
  if (const Estimate* found = find_estimate(in.begun, part)) return *found;
  throw InputError(
      {in.path, bench::name_of(part), "no estimate", "a finished part, because others depend on it"});
}

Eigen::MatrixXd prior_covariance(const Estimate& estimate, const std::vector<std::string>& names)
{
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = bench::index_of(estimate, names[static_cast<std::size_t>(i)]);
      const Eigen::Index b = bench::index_of(estimate, names[static_cast<std::size_t>(j)]);
      check(a >= 0 && b >= 0, "an estimate has the numbers of its part");
      covariance(i, j) = estimate.covariance(a, b);
    }
  }
  const double t_ratio = bench::t_95(estimate.dof) / bench::t_95(std::numeric_limits<double>::infinity());
  return t_ratio * t_ratio * covariance;
}

std::vector<std::string> distortion_names(bool is_right)
{
  std::vector<std::string> names = bench::shared_estimate_names(CalibrationPart::distortion);
  std::erase_if(names, [&](const std::string& name) { return !name.starts_with(side_name(is_right)); });
  return names;
}

double value_in(const Estimate& estimate, const std::string& name)
{
  const Eigen::Index k = bench::index_of(estimate, name);
  check(k >= 0, "an estimate has the numbers of its part");
  return estimate.values[k];
}

Pose pose_in(const Estimate& estimate, const std::string& name)
{
  std::vector<double> six;
  for (const std::string& number : bench::pose_number_names(name)) six.push_back(value_in(estimate, number));
  return bench::pose_of(bench::pose_parameters_of(six));
}

MeanPosition mean_position(const std::vector<Eigen::Vector3d>& places)
{
  MeanPosition mean;
  for (const Eigen::Vector3d& p : places) mean.p_mm += p / static_cast<double>(places.size());
  double sum_sq = 0.0;
  for (const Eigen::Vector3d& p : places) {
    sum_sq += (p - mean.p_mm).squaredNorm();
    mean.furthest_mm = std::max(mean.furthest_mm, (p - mean.p_mm).norm());
  }
  if (places.size() > 1) mean.sd_mm = std::sqrt(sum_sq / (3.0 * static_cast<double>(places.size() - 1)));
  return mean;
}

std::vector<Eigen::Vector3d> places_of(const Task& task, const CalibrationMark& mark)
{
  const TaskKind::Samples samples = task.kind->traits().samples;
  const bool is_position = samples == TaskKind::Samples::position;
  std::vector<Eigen::Vector3d> places;
  if (!is_position && samples != TaskKind::Samples::hold) return places;
  const std::size_t first = is_position ? 1 : 0, body_at = is_position ? 3 : 7;
  for (std::size_t k = first; k < mark.rows.size(); ++k) {
    const std::vector<double>& row = mark.rows[k];
    const Eigen::Vector3d p = sampled_position(row);
    places.push_back(row.size() > body_at ? Eigen::Vector3d(sampled_pose(row, body_at).inverse() * p) : p);
  }
  return places;
}

std::string screen_message(const InputError& error)
{
  const InputError::Facts& facts = error.facts();
  return (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " +
         facts.wanted;
}

void require_static(CalibrationPart id, const Task& task, const CalibrationMark& mark,
                    const std::string& path)
{
  // Ten times the noise of an optical tracker at the tip of a probe.
  constexpr double least_limit_mm = 3.0;
  const std::vector<Eigen::Vector3d> places = places_of(task, mark);
  const MeanPosition mean = mean_position(places);
  // The noise of a static tool is as large between successive samples as about their mean; a motion is not.
  constexpr double most_deviations = 3.0;
  const double furthest_mm = std::max(least_limit_mm, most_deviations * successive_noise_mm(places));
  if (mean.furthest_mm > furthest_mm) {
    throw PartRefusal({path, std::string(part_object(id).name()) + ", " + task.name,
                       "samples up to " + short_decimal(mean.furthest_mm, 1) + " mm from their mean",
                       "at most " + short_decimal(furthest_mm, 1) + " mm; hold it still and sample again"});
  }
}

std::string untouched_text(const Task& task, const std::vector<bool>& touched)
{
  if (task.dials.empty() || task.is_start_valid) return {};
  const TaskKind::Traits& kind = task.kind->traits();
  const bool is_done = kind.has_two_lines ? std::ranges::all_of(touched, std::identity())
                                          : std::ranges::any_of(touched, std::identity());
  if (is_done) return {};
  const bool is_part = std::ranges::any_of(touched, std::identity());
  const std::string thing = is_part ? "other line" : kind.thing;
  const bool is_plural = !is_part && kind.has_two_lines;
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
    return "Not taken: " + dial.name + " " + bench::text(values[k], 2, dial.unit) +
           " is implausible, expected is " +
           range_text(dial.least_plausible, dial.most_plausible, dial.unit) +
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
                            const Estimate& estimate, const Calibration& nominal)
{
  const auto text = [](const std::string& name, double value, double least, double most,
                       const std::string& unit) {
    return name + " " + bench::text(value, 2, unit) + " is far from the expected " +
           range_text(least, most, unit) +
           ". The readings agree with each other, so they must be measured again: check the instrument, its "
           "unit and what is measured. The same readings are then accepted.";
  };
  for (const Task& task : tasks) {
    const CalibrationMark* const mark = find_mark(record, task.name);
    const bool has_reading = task.kind->traits().is_reading;
    if (!has_reading || mark == nullptr || implausible_text(task, mark->rows[0]).empty()) continue;
    const Dial& dial = task.dials[0];
    return text(task.name + ":", mark->rows[0][0], dial.least_plausible, dial.most_plausible, dial.unit);
  }
  struct Expected {
    const char* name;
    double least, most;
  };
  const double eye_px = nominal.eyes.left.distance_px, image_mm = nominal.image_distance_mm;
  // Adults are 0.75 to 1.3 times as large as a reference body; displays and rectangles are built near their
  // nominal sizes, and square pixels are usual.
  for (const Expected& e : {Expected{"subject.scale", 0.75, 1.35},
                            {"ipd", 45.0, 80.0},
                            {"left.distance", 0.5 * eye_px, 2.0 * eye_px},
                            {"right.distance", 0.5 * eye_px, 2.0 * eye_px},
                            {"left.depth", 0.3 * image_mm, 3.0 * image_mm},
                            {"right.depth", 0.3 * image_mm, 3.0 * image_mm},
                            {"left.pixel_aspect", 0.7, 1.4},
                            {"right.pixel_aspect", 0.7, 1.4}}) {
    const Eigen::Index k = bench::index_of(estimate, e.name);
    if (k < 0 || (estimate.values[k] >= e.least && estimate.values[k] <= e.most)) continue;
    return text(e.name, estimate.values[k], e.least, e.most, estimate.units[static_cast<std::size_t>(k)]);
  }
  return {};
}

}  // namespace vrda::calibration
