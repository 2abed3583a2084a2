#include "guide/solve_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/fiducial_fit.hpp"
#include "core/error.hpp"
#include "guide/marks.hpp"
#include "guide/parts.hpp"
#include "guide/refusal.hpp"
#include "guide/session.hpp"
#include "guide/task.hpp"
#include "settings/settings_text.hpp"

namespace vrda {
namespace {

Estimate both_eyes(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                   const std::string& path)
{
  Estimate estimate;
  for (const bool is_right : {false, true}) {
    if (part == CalibrationPart::viewport)
      append(estimate, viewport_of(bench, begun, is_right, path).estimate);
    if (part == CalibrationPart::distortion)
      append(estimate, distortion_of(bench, begun, is_right, path).estimate);
    if (part == CalibrationPart::eyepoints)
      append(estimate, eyepoint_of(bench, begun, is_right, path).fit.estimate);
  }
  return estimate;
}

Estimate given(const std::string& name, const std::string& unit, double value, double sd)
{
  Estimate estimate;
  estimate.names = {name};
  estimate.units = {unit};
  estimate.values = Eigen::VectorXd::Constant(1, value);
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, sd * sd);
  estimate.dof = std::numeric_limits<double>::infinity();
  return estimate;
}

/// Number of a task of ipd; empty if the bench does not have the task.
std::optional<double> number_of(const Calibration& begun, const char* task)
{
  const CalibrationMark* mark = mark_of(begun.records.at(CalibrationPart::ipd), task);
  return mark == nullptr ? std::nullopt : std::optional<double>(mark->rows[0][0]);
}

Estimate measured_ipd(const BenchFile& bench, const Calibration& begun, const std::string& path)
{
  if (const std::optional<double> ipd_mm = number_of(begun, "pupillary distance"))
    return given("ipd", "mm", *ipd_mm, bench.calibration.pupillometer_sd_mm);
  const EyeRectangles left = eyepoint_of(bench, begun, false, path);
  const EyeRectangles right = eyepoint_of(bench, begun, true, path);
  const PupilDistance found = pupil_distance(left, right, bench.calibration.sight_sd_px);
  return given("ipd", "mm", found.ipd_mm, found.sd_mm);
}

Estimate solved_ipd(const BenchFile& bench, const Calibration& begun, const std::string& path)
{
  Estimate estimate = measured_ipd(bench, begun, path);
  const double ipd_mm = estimate.values[0], depth_mm = *number_of(begun, "image distance");
  const double arms_mm = *number_of(begun, "left arm") + *number_of(begun, "right arm");
  constexpr double most_apart_mm = 1.0;
  if (std::abs(arms_mm - ipd_mm) > most_apart_mm) {
    estimate.remarks.push_back("distance of the arms " + rounded_text(arms_mm, 1) + " mm, of the eyes " +
                               rounded_text(ipd_mm, 1) + " mm: adjust the arms");
  }
  estimate.remarks.push_back(
      "an error of 1 mm (eyes further apart) shifts an object at " + rounded_text(depth_mm, 0) + " mm by " +
      rounded_text(depth_error_mm(depth_mm, ipd_mm, ipd_mm + 1.0), 1) + " mm away from the viewer");
  return estimate;
}

Estimate solved_subject(const BenchFile& bench, const Calibration& begun, const std::string& path)
{
  std::vector<LandmarkDistance> distances;
  const std::vector<MarkedTask> tasks = marked_tasks(CalibrationPart::subject, bench, begun);
  for (const MarkedTask& t : tasks) {
    const CalibrationLandmarks& pair = bench.calibration.landmarks[static_cast<std::size_t>(t.task.index)];
    distances.push_back({pair.name, pair.model_mm, t.mark->rows[0][0]});
  }
  const ScaleFit fit = fitted(names_of(tasks), [&] { return fit_scale(distances, path); });
  if (fit.is_uneven) {
    std::string ratios;
    for (const LandmarkDistance& d : distances)
      ratios += (ratios.empty() ? "" : ", ") + d.name + " " + rounded_text(d.subject_mm / d.model_mm, 3);
    throw PartRefusal({path, "subject", "distances with different scales: " + ratios,
                       "distances with one scale; measure again, or run the pipeline with these landmarks "
                       "(schemas/scaling.md)"});
  }
  return fit.estimate;
}

/// Applies a new viewport; resets an old distortion that folds within it.
void put_viewport(Calibration& calibration, const Estimate& found)
{
  put_found(calibration.eyes, CalibrationPart::viewport, found);
  for (Eye* eye : {&calibration.eyes.left, &calibration.eyes.right}) {
    if (unusable(*eye, "", "")) eye->distortion.k1 = eye->distortion.k2 = 0.0;
  }
}

void solve_stop(CalibrationRecord& record)
{
  // An empty estimate: the part only zeroes the stage.
  record.estimate.emplace();
  record.estimate->dof = std::numeric_limits<double>::infinity();
}

void put_solved_eyes(CalibrationPart part, const BenchFile& bench, Calibration& c, const std::string& path)
{
  const EyesFit fit = eyes_of(part, bench, c, path);
  c.eyes = fit.eyes;
  (part == CalibrationPart::head ? c.X_headbody_eyes : c.X_table_eyes) = six_numbers_of(fit.X_carrier_eyes);
  c.records[part].estimate = fit.estimate;
}

void put_solved(CalibrationPart part, const BenchFile& bench, Calibration& c, const std::string& path)
{
  CalibrationRecord& record = c.records.at(part);
  switch (part) {
    case CalibrationPart::viewport:
      record.estimate = both_eyes(part, bench, c, path);
      return put_viewport(c, *record.estimate);
    case CalibrationPart::distortion:
    case CalibrationPart::eyepoints:
      record.estimate = both_eyes(part, bench, c, path);
      return put_found(c.eyes, part, *record.estimate);
    case CalibrationPart::ipd:
      record.estimate = solved_ipd(bench, c, path);
      c.image_distance_mm = *number_of(c, "image distance");
      return put_found(c.eyes, part, *record.estimate);
    case CalibrationPart::rails:
      record.estimate = table_of(bench, c, path).estimate;
      c.X_tracker_table = six_numbers_of(place_in(*record.estimate, "table"));
      c.stage_direction_table = Eigen::Vector3d::UnitX();
      return;
    case CalibrationPart::stop:
      return solve_stop(record);
    case CalibrationPart::probe:
      record.estimate = pivot_of(bench, c, path).estimate;
      return;
    case CalibrationPart::subject:
      record.estimate = solved_subject(bench, c, path);
      c.subject_scale = value_in(*record.estimate, "subject.scale");
      return;
    case CalibrationPart::bullseye:
    case CalibrationPart::head:
      return put_solved_eyes(part, bench, c, path);
    case CalibrationPart::leg:
    case CalibrationPart::femur:
    case CalibrationPart::tibia: {
      const FiducialFit fit = model_of(part, bench, c, path);
      c.X_body_model[static_cast<std::size_t>(role_of(part))] = six_numbers_of(fit.X_body_model);
      record.estimate = fit.estimate;
      return;
    }
  }
}

/// Decimals for two significant digits of a 95 % interval.
int decimals_of(double half_width)
{
  if (!(half_width > 0.0)) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width))), 0, 6);
}

}  // namespace

Calibration solved_part(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                        const std::string& path)
{
  Calibration solved = begun;
  put_solved(part, bench, solved, path);
  if (const std::optional<InputError::Facts> facts = unusable(solved.eyes, path)) throw PartRefusal(*facts);
  return solved;
}

void require_earlier_marks(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                           const std::string& path)
{
  const bool is_seen = part == CalibrationPart::bullseye || part == CalibrationPart::head;
  const bool is_from_rectangles = part == CalibrationPart::ipd && !bench.calibration.has_pupillometer;
  if (!is_seen && !is_from_rectangles) return;
  try {
    for (const bool is_right : {false, true}) eyepoint_of(bench, begun, is_right, path);
  } catch (const PartRefusal& refusal) {
    const InputError::Facts& facts = refusal.facts();
    throw InputError(
        {facts.file, "per_person.eyepoints: " + facts.field, facts.found,
         facts.wanted + ". Repeat eyepoints with --anew, because " + name_of(part) + " depends on it"});
  }
}

std::vector<std::string> round_remarks(CalibrationPart part, const BenchFile& bench, const Calibration& begun,
                                       const Task& done, const std::string& path)
{
  if (part == CalibrationPart::viewport)
    return viewport_of(bench, begun, done.is_right, path).estimate.remarks;
  if (part == CalibrationPart::distortion)
    return distortion_of(bench, begun, done.is_right, path).estimate.remarks;
  if (part == CalibrationPart::eyepoints)
    return eyepoint_of(bench, begun, done.is_right, path).fit.estimate.remarks;
  if (part == CalibrationPart::rails) require_good_rail(done, bench, begun, path);
  return {};
}

void require_still(CalibrationPart part, const Task& task, const CalibrationMark& mark,
                   const std::string& path)
{
  // Ten times the noise of an optical tracker at the tip of a probe.
  constexpr double furthest_mm = 3.0;
  std::vector<Eigen::Vector3d> places;
  if (task.kind == TaskKind::bullseye) places = marker_places(mark);
  if (task.kind == TaskKind::hold) {
    for (const std::vector<double>& row : mark.rows)
      places.push_back(sampled_pose(row, 7).inverse() * sampled_position(row));
  }
  const MeanPlace mean = mean_place(places);
  if (mean.furthest_mm > furthest_mm) {
    throw PartRefusal({path, std::string(name_of(part)) + ", " + task.name,
                       "samples up to " + rounded_text(mean.furthest_mm, 1) + " mm from their mean",
                       "at most " + rounded_text(furthest_mm, 1) + " mm; hold it still and sample again"});
  }
}

std::vector<std::string> lines_of(const Estimate& estimate)
{
  std::vector<std::string> lines;
  for (Eigen::Index k = 0; k < estimate.values.size(); ++k) {
    const auto n = static_cast<std::size_t>(k);
    const double half_width = half_width_95(estimate, k);
    const int decimals = decimals_of(half_width);
    lines.push_back(estimate.names[n] + " " + rounded_text(estimate.values[k], decimals) + " +- " +
                    rounded_text(half_width, decimals) +
                    (estimate.units[n].empty() ? "" : " " + estimate.units[n]));
  }
  if (!estimate.residuals.empty()) {
    lines.push_back("residual " + rounded_text(estimate.residual_rms, 3) + " " + estimate.residual_unit +
                    " (root mean square)");
  }
  lines.insert(lines.end(), estimate.remarks.begin(), estimate.remarks.end());
  return lines;
}

Calibration solved_again(const BenchFile& bench, const Calibration& calibration, const std::string& path)
{
  Calibration solved = calibration;
  const auto has_estimate = [&](CalibrationPart below) {
    const auto found = solved.records.find(below);
    return found != solved.records.end() && found->second.estimate;
  };
  for (const CalibrationPart part : parts_of(bench)) {
    const auto record = solved.records.find(part);
    if (record == solved.records.end() || record->second.marks.empty()) continue;
    take_numbers(record->second, part, bench);
    // Dependent parts also read the marks of an unsolved part.
    require_of_plan(part, bench, solved, path);
    // A dependency without an estimate is being repeated.
    const std::vector<CalibrationPart> below = rests_on(part, bench);
    if (!std::all_of(below.begin(), below.end(), has_estimate)) continue;
    const std::vector<Task> tasks = tasks_of(part, bench, solved);
    if (next_task(tasks, record->second) < tasks.size()) continue;
    solved = solved_part(part, bench, solved, path);
  }
  return solved;
}

}  // namespace vrda
