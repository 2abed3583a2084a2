#include "calibration_tasks/solve_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/fiducial_fit.hpp"
#include "calibration_tasks/marks.hpp"
#include "calibration_tasks/parts.hpp"
#include "calibration_tasks/refusal.hpp"
#include "calibration_tasks/session.hpp"
#include "calibration_tasks/task.hpp"
#include "core/error.hpp"
#include "settings/settings_text.hpp"

namespace vrda::calibration_tasks {
namespace {

calibration::Estimate both_eyes(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                const bench_files::Calibration& begun, const std::string& path)
{
  calibration::Estimate estimate;
  for (const bool is_right : {false, true}) {
    if (part == bench_files::CalibrationPart::viewport)
      calibration::append(estimate, solve_viewport(bench, begun, is_right, path).estimate);
    if (part == bench_files::CalibrationPart::distortion)
      calibration::append(estimate, solve_distortion(bench, begun, is_right, path).estimate);
    if (part == bench_files::CalibrationPart::eyepoints)
      calibration::append(estimate, solve_eye_rectangles(bench, begun, is_right, path).fit.estimate);
  }
  return estimate;
}

calibration::Estimate given(const std::string& name, const std::string& unit, double value, double sd)
{
  calibration::Estimate estimate;
  estimate.names = {name};
  estimate.units = {unit};
  estimate.values = Eigen::VectorXd::Constant(1, value);
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, sd * sd);
  estimate.dof = std::numeric_limits<double>::infinity();
  return estimate;
}

/// Number of a task of ipd; empty if the bench does not have the task.
std::optional<double> number_of(const bench_files::Calibration& begun, const char* task)
{
  const bench_files::CalibrationMark* mark =
      find_mark(begun.records.at(bench_files::CalibrationPart::ipd), task);
  return mark == nullptr ? std::nullopt : std::optional<double>(mark->rows[0][0]);
}

calibration::Estimate measured_ipd(const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                                   const std::string& path)
{
  if (const std::optional<double> ipd_mm = number_of(begun, "pupillary distance"))
    return given("ipd", "mm", *ipd_mm, bench.calibration.pupillometer_sd_mm);
  const calibration::EyeRectangles left = solve_eye_rectangles(bench, begun, false, path);
  const calibration::EyeRectangles right = solve_eye_rectangles(bench, begun, true, path);
  const calibration::PupilDistance found =
      calibration::pupil_distance(left, right, bench.calibration.sight_sd_px);
  return given("ipd", "mm", found.ipd_mm, found.sd_mm);
}

calibration::Estimate solved_ipd(const bench_files::BenchFile& bench, const bench_files::Calibration& begun,
                                 const std::string& path)
{
  calibration::Estimate estimate = measured_ipd(bench, begun, path);
  const double ipd_mm = estimate.values[0], depth_mm = *number_of(begun, "image distance");
  const double arms_mm = *number_of(begun, "left arm") + *number_of(begun, "right arm");
  constexpr double most_apart_mm = 1.0;
  if (std::abs(arms_mm - ipd_mm) > most_apart_mm) {
    estimate.remarks.push_back("distance of the arms " + settings::rounded_text(arms_mm, 1) +
                               " mm, of the eyes " + settings::rounded_text(ipd_mm, 1) +
                               " mm: adjust the arms");
  }
  estimate.remarks.push_back(
      "an error of 1 mm (eyes further apart) shifts an object at " + settings::rounded_text(depth_mm, 0) +
      " mm by " + settings::rounded_text(calibration::depth_error_mm(depth_mm, ipd_mm, ipd_mm + 1.0), 1) +
      " mm away from the viewer");
  return estimate;
}

calibration::Estimate solved_subject(const bench_files::BenchFile& bench,
                                     const bench_files::Calibration& begun, const std::string& path)
{
  std::vector<calibration::LandmarkDistance> distances;
  const std::vector<MarkedTask> tasks = marked_tasks(bench_files::CalibrationPart::subject, bench, begun);
  for (const MarkedTask& t : tasks) {
    const bench_files::CalibrationLandmarks& pair =
        bench.calibration.landmarks[static_cast<std::size_t>(t.task.index)];
    distances.push_back({pair.name, pair.model_mm, t.mark->rows[0][0]});
  }
  const calibration::ScaleFit fit =
      run_fit(names_of(tasks), [&] { return calibration::fit_scale(distances, path); });
  if (fit.is_nonuniform) {
    std::string ratios;
    for (const calibration::LandmarkDistance& d : distances)
      ratios +=
          (ratios.empty() ? "" : ", ") + d.name + " " + settings::rounded_text(d.subject_mm / d.model_mm, 3);
    throw PartRefusal({path, "subject", "distances with different scales: " + ratios,
                       "distances with one scale; measure again, or run the pipeline with these landmarks "
                       "(schemas/scaling.md)"});
  }
  return fit.estimate;
}

/// Applies a new viewport; resets an old distortion that folds within it.
void put_viewport(bench_files::Calibration& calibration, const calibration::Estimate& found)
{
  apply_estimate(calibration.eyes, bench_files::CalibrationPart::viewport, found);
  for (optics::Eye* eye : {&calibration.eyes.left, &calibration.eyes.right}) {
    if (optics::usability_error(*eye, "", "")) eye->distortion.k1 = eye->distortion.k2 = 0.0;
  }
}

void solve_stop(bench_files::CalibrationRecord& record)
{
  // An empty estimate: the part only zeroes the stage.
  record.estimate.emplace();
  record.estimate->dof = std::numeric_limits<double>::infinity();
}

void put_solved_eyes(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                     bench_files::Calibration& c, const std::string& path)
{
  const calibration::EyesFit fit = solve_eye_pose(part, bench, c, path);
  c.eyes = fit.eyes;
  (part == bench_files::CalibrationPart::head ? c.X_headbody_eyes : c.X_table_eyes) =
      tracking::pose_parameters_of(fit.X_carrier_eyes);
  c.records[part].estimate = fit.estimate;
}

void put_solved(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                bench_files::Calibration& c, const std::string& path)
{
  bench_files::CalibrationRecord& record = c.records.at(part);
  switch (part) {
    case bench_files::CalibrationPart::viewport:
      record.estimate = both_eyes(part, bench, c, path);
      return put_viewport(c, *record.estimate);
    case bench_files::CalibrationPart::distortion:
    case bench_files::CalibrationPart::eyepoints:
      record.estimate = both_eyes(part, bench, c, path);
      return apply_estimate(c.eyes, part, *record.estimate);
    case bench_files::CalibrationPart::ipd:
      record.estimate = solved_ipd(bench, c, path);
      c.image_distance_mm = *number_of(c, "image distance");
      return apply_estimate(c.eyes, part, *record.estimate);
    case bench_files::CalibrationPart::rails:
      record.estimate = solve_table(bench, c, path).estimate;
      c.X_tracker_table = tracking::pose_parameters_of(pose_in(*record.estimate, "table"));
      c.stage_direction_table = Eigen::Vector3d::UnitX();
      return;
    case bench_files::CalibrationPart::stop:
      return solve_stop(record);
    case bench_files::CalibrationPart::probe:
      record.estimate = solve_pivot(bench, c, path).estimate;
      return;
    case bench_files::CalibrationPart::subject:
      record.estimate = solved_subject(bench, c, path);
      c.subject_scale = value_in(*record.estimate, "subject.scale");
      return;
    case bench_files::CalibrationPart::bullseye:
    case bench_files::CalibrationPart::head:
      return put_solved_eyes(part, bench, c, path);
    case bench_files::CalibrationPart::leg:
    case bench_files::CalibrationPart::femur:
    case bench_files::CalibrationPart::tibia: {
      const calibration::FiducialFit fit = solve_model_pose(part, bench, c, path);
      c.X_body_model[static_cast<std::size_t>(role_of(part))] =
          tracking::pose_parameters_of(fit.X_body_model);
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

bench_files::Calibration solve_part(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                    const bench_files::Calibration& begun, const std::string& path)
{
  bench_files::Calibration solved = begun;
  put_solved(part, bench, solved, path);
  if (const std::optional<InputError::Facts> facts = optics::usability_error(solved.eyes, path))
    throw PartRefusal(*facts);
  return solved;
}

void require_earlier_fits(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                          const bench_files::Calibration& begun, const std::string& path)
{
  const bool is_seen =
      part == bench_files::CalibrationPart::bullseye || part == bench_files::CalibrationPart::head;
  const bool is_from_rectangles =
      part == bench_files::CalibrationPart::ipd && !bench.calibration.has_pupillometer;
  if (!is_seen && !is_from_rectangles) return;
  try {
    for (const bool is_right : {false, true}) solve_eye_rectangles(bench, begun, is_right, path);
  } catch (const PartRefusal& refusal) {
    const InputError::Facts& facts = refusal.facts();
    throw InputError({facts.file, "per_person.eyepoints: " + facts.field, facts.found,
                      facts.wanted + ". Repeat eyepoints with --anew, because " + bench_files::name_of(part) +
                          " depends on it"});
  }
}

std::vector<std::string> group_remarks(bench_files::CalibrationPart part, const bench_files::BenchFile& bench,
                                       const bench_files::Calibration& begun, const Task& done,
                                       const std::string& path)
{
  if (part == bench_files::CalibrationPart::viewport)
    return solve_viewport(bench, begun, done.is_right, path).estimate.remarks;
  if (part == bench_files::CalibrationPart::distortion)
    return solve_distortion(bench, begun, done.is_right, path).estimate.remarks;
  if (part == bench_files::CalibrationPart::eyepoints)
    return solve_eye_rectangles(bench, begun, done.is_right, path).fit.estimate.remarks;
  if (part == bench_files::CalibrationPart::rails) require_good_rail(done, bench, begun, path);
  return {};
}

void require_static(bench_files::CalibrationPart part, const Task& task,
                    const bench_files::CalibrationMark& mark, const std::string& path)
{
  // Ten times the noise of an optical tracker at the tip of a probe.
  constexpr double furthest_mm = 3.0;
  std::vector<Eigen::Vector3d> places;
  if (task.kind == TaskKind::bullseye) places = marker_positions(mark);
  if (task.kind == TaskKind::hold) {
    for (const std::vector<double>& row : mark.rows)
      places.push_back(sampled_pose(row, 7).inverse() * sampled_position(row));
  }
  const MeanPosition mean = mean_position(places);
  if (mean.furthest_mm > furthest_mm) {
    throw PartRefusal(
        {path, std::string(bench_files::name_of(part)) + ", " + task.name,
         "samples up to " + settings::rounded_text(mean.furthest_mm, 1) + " mm from their mean",
         "at most " + settings::rounded_text(furthest_mm, 1) + " mm; hold it still and sample again"});
  }
}

std::vector<std::string> estimate_lines(const calibration::Estimate& estimate)
{
  std::vector<std::string> lines;
  for (Eigen::Index k = 0; k < estimate.values.size(); ++k) {
    const auto n = static_cast<std::size_t>(k);
    const double half_width = calibration::half_width_95(estimate, k);
    const int decimals = decimals_of(half_width);
    lines.push_back(estimate.names[n] + " " + settings::rounded_text(estimate.values[k], decimals) + " +- " +
                    settings::rounded_text(half_width, decimals) +
                    (estimate.units[n].empty() ? "" : " " + estimate.units[n]));
  }
  if (!estimate.residuals.empty()) {
    lines.push_back("residual " + settings::rounded_text(estimate.residual_rms, 3) + " " +
                    estimate.residual_unit + " (root mean square)");
  }
  lines.insert(lines.end(), estimate.remarks.begin(), estimate.remarks.end());
  return lines;
}

bench_files::Calibration solve_again(const bench_files::BenchFile& bench,
                                     const bench_files::Calibration& calibration, const std::string& path)
{
  bench_files::Calibration solved = calibration;
  const auto has_estimate = [&](bench_files::CalibrationPart below) {
    const auto found = solved.records.find(below);
    return found != solved.records.end() && found->second.estimate;
  };
  for (const bench_files::CalibrationPart part : parts_of(bench)) {
    const auto record = solved.records.find(part);
    if (record == solved.records.end() || record->second.marks.empty()) continue;
    update_made_with(record->second, part, bench);
    // Dependent parts also read the marks of an unsolved part.
    require_current_record(part, bench, solved, path);
    // A dependency without an estimate is being repeated.
    const std::vector<bench_files::CalibrationPart> below = dependencies_of(part, bench);
    if (!std::all_of(below.begin(), below.end(), has_estimate)) continue;
    const std::vector<Task> tasks = tasks_of(part, bench, solved);
    if (next_task(tasks, record->second) < tasks.size()) continue;
    solved = solve_part(part, bench, solved, path);
  }
  return solved;
}

}  // namespace vrda::calibration_tasks
