#include "calibration/solve_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/fiducial_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/session.hpp"
#include "calibration/task.hpp"
#include "core/error.hpp"
#include "show/settings_text.hpp"

namespace vrda::calibration {
namespace {

bool is_by_eye(CalibrationPart part)
{
  return part == CalibrationPart::viewport || part == CalibrationPart::distortion ||
         part == CalibrationPart::eyepoints;
}

bench::Estimate solved_eye(CalibrationPart part, const PartInput& in, bool is_right)
{
  if (part == CalibrationPart::viewport) return solve_viewport(in, is_right);
  if (part == CalibrationPart::distortion) return solve_distortion(in, is_right).estimate;
  return solve_eye_rectangles(in, is_right).fit.estimate;
}

bench::Estimate both_eyes(CalibrationPart part, const PartInput& in)
{
  bench::Estimate estimate;
  for (const bool is_right : {false, true}) bench::append(estimate, solved_eye(part, in, is_right));
  return estimate;
}

bench::Estimate given(const std::string& name, const std::string& unit, double value, double sd)
{
  bench::Estimate estimate;
  estimate.names = {name};
  estimate.units = {unit};
  estimate.values = Eigen::VectorXd::Constant(1, value);
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, sd * sd);
  estimate.dof = std::numeric_limits<double>::infinity();
  return estimate;
}

/// Number of a task of ipd; empty if the bench does not have the task.
std::optional<double> number_of(const PartInput& in, const char* task)
{
  const CalibrationMark* mark = find_mark(in.begun.records.at(CalibrationPart::ipd), task);
  return mark == nullptr ? std::nullopt : std::optional<double>(mark->rows[0][0]);
}

bench::Estimate measured_ipd(const PartInput& in)
{
  if (const std::optional<double> ipd_mm = number_of(in, "pupillary distance"))
    return given("ipd", "mm", *ipd_mm, in.bench.calibration.pupillometer_sd_mm);
  const calibration::EyeRectangles left = solve_eye_rectangles(in, false);
  const calibration::EyeRectangles right = solve_eye_rectangles(in, true);
  const calibration::PupilDistance found =
      calibration::pupil_distance(left, right, in.bench.calibration.sight_sd_px);
  return given("ipd", "mm", found.ipd_mm, found.sd_mm);
}

bench::Estimate solved_ipd(const PartInput& in)
{
  bench::Estimate estimate = measured_ipd(in);
  const double ipd_mm = estimate.values[0], depth_mm = *number_of(in, "image distance");
  const double arms_mm = *number_of(in, "left arm") + *number_of(in, "right arm");
  constexpr double most_apart_mm = 1.0;
  if (std::abs(arms_mm - ipd_mm) > most_apart_mm) {
    estimate.remarks.push_back("distance of the arms " + show::rounded_text(arms_mm, 1) +
                               " mm, of the eyes " + show::rounded_text(ipd_mm, 1) +
                               " mm: adjust the arms");
  }
  estimate.remarks.push_back(
      "measured 1 mm too large, it shows an object at " + show::rounded_text(depth_mm, 0) + " mm " +
      show::rounded_text(-calibration::depth_error_mm(depth_mm, ipd_mm + 1.0, ipd_mm), 1) +
      " mm nearer to the viewer");
  return estimate;
}

bench::Estimate solved_subject(const PartInput& in)
{
  std::vector<calibration::LandmarkDistance> distances;
  const std::vector<MarkedTask> tasks = marked_tasks(CalibrationPart::subject, in);
  for (const MarkedTask& t : tasks) {
    const CalibrationLandmarks& pair = in.bench.calibration.landmarks[static_cast<std::size_t>(t.task.index)];
    distances.push_back({pair.name, pair.model_mm, t.mark->rows[0][0]});
  }
  const calibration::ScaleFit fit =
      run_fit(names_of(tasks), [&] { return calibration::fit_scale(distances, in.path); });
  if (fit.is_nonuniform) {
    std::string ratios;
    for (const calibration::LandmarkDistance& d : distances)
      ratios +=
          (ratios.empty() ? "" : ", ") + d.name + " " + show::rounded_text(d.subject_mm / d.model_mm, 3);
    throw PartRefusal({in.path, "subject", "distances with different scales: " + ratios,
                       "distances with one scale; measure again, or run the pipeline with these landmarks "
                       "(schemas/scaling.md)"});
  }
  return fit.estimate;
}

/// Applies a new viewport; resets an old distortion that folds within it.
void put_viewport(Calibration& calibration, const bench::Estimate& found)
{
  apply_estimate(calibration.eyes, CalibrationPart::viewport, found);
  for (view::Eye* eye : {&calibration.eyes.left, &calibration.eyes.right}) {
    if (view::usability_error(*eye, "", "")) eye->distortion.k1 = eye->distortion.k2 = 0.0;
  }
}

void put_model(Calibration& c, BodyRole role, const Pose& X_body_model)
{
  c.X_body_model[static_cast<std::size_t>(role)] = bench::pose_parameters_of(X_body_model);
}

/// After new landmarks of one bone, those of the other replace its functional placement.
void put_landmarks(Calibration& c)
{
  if (find_estimate(c, CalibrationPart::functional) == nullptr) return;
  for (const CalibrationPart part : {CalibrationPart::femur, CalibrationPart::tibia}) {
    if (const bench::Estimate* landmarks = find_estimate(c, part))
      put_model(c, role_of(part), pose_in(*landmarks, bench::name_of(part)));
  }
}

void put_solved(CalibrationPart part, const PartInput& in, Calibration& c)
{
  CalibrationRecord& record = c.records.at(part);
  switch (part) {
    case CalibrationPart::viewport:
      record.estimate = both_eyes(part, in);
      return put_viewport(c, *record.estimate);
    case CalibrationPart::distortion:
    case CalibrationPart::eyepoints:
      record.estimate = both_eyes(part, in);
      return apply_estimate(c.eyes, part, *record.estimate);
    case CalibrationPart::ipd:
      record.estimate = solved_ipd(in);
      c.image_distance_mm = *number_of(in, "image distance");
      return apply_estimate(c.eyes, part, *record.estimate);
    case CalibrationPart::rails:
      record.estimate = solve_table(in).estimate;
      c.X_tracker_table = bench::pose_parameters_of(pose_in(*record.estimate, "table"));
      c.stage_direction_table = Eigen::Vector3d::UnitX();
      return;
    case CalibrationPart::stop:
      // An empty estimate: the part only zeroes the stage.
      record.estimate.emplace();
      record.estimate->dof = std::numeric_limits<double>::infinity();
      return;
    case CalibrationPart::probe:
      record.estimate = solve_pivot(in).estimate;
      return;
    case CalibrationPart::subject:
      record.estimate = solved_subject(in);
      c.subject_scale = value_in(*record.estimate, "subject.scale");
      return;
    case CalibrationPart::bullseye:
    case CalibrationPart::head: {
      const calibration::EyesFit fit = solve_eye_pose(part, in);
      c.eyes = fit.eyes;
      (part == CalibrationPart::head ? c.X_headbody_eyes : c.X_table_eyes) =
          bench::pose_parameters_of(fit.X_carrier_eyes);
      record.estimate = fit.estimate;
      return;
    }
    case CalibrationPart::leg:
    case CalibrationPart::femur:
    case CalibrationPart::tibia: {
      const calibration::FiducialFit fit = solve_model_pose(part, in);
      put_model(c, role_of(part), fit.X_body_model);
      record.estimate = fit.estimate;
      return put_landmarks(c);
    }
    case CalibrationPart::functional: {
      const calibration::FunctionalFit fit = solve_functional(in);
      put_model(c, BodyRole::femur, fit.X_thigh_femur);
      put_model(c, BodyRole::tibia, fit.X_shank_tibia);
      record.estimate = fit.estimate;
      return;
    }
  }
}

}  // namespace

Calibration solve_part(CalibrationPart part, const PartInput& in)
{
  Calibration solved = in.begun;
  put_solved(part, in, solved);
  if (const std::optional<InputError::Facts> facts = view::usability_error(solved.eyes, in.path))
    throw PartRefusal(*facts);
  return solved;
}

void require_earlier_fits(CalibrationPart part, const PartInput& in)
{
  const bool is_seen = part == CalibrationPart::bullseye || part == CalibrationPart::head;
  const bool is_from_rectangles = part == CalibrationPart::ipd && !in.bench.calibration.has_pupillometer;
  if (!is_seen && !is_from_rectangles) return;
  try {
    for (const bool is_right : {false, true}) solve_eye_rectangles(in, is_right);
  } catch (const PartRefusal& refusal) {
    const InputError::Facts& facts = refusal.facts();
    throw InputError({facts.file, "per_person.eyepoints: " + facts.field, facts.found,
                      facts.wanted + ". Repeat eyepoints with --anew, because " + bench::name_of(part) +
                          " depends on it"});
  }
}

std::vector<std::string> group_remarks(CalibrationPart part, const Task& done, const PartInput& in)
{
  if (is_by_eye(part)) return solved_eye(part, in, done.is_right).remarks;
  if (part == CalibrationPart::functional) return bend_remarks(done, in);
  if (part == CalibrationPart::rails) require_good_rail(done, in);
  return {};
}

namespace {

/// Root mean square distance from the mean of white noise with these differences of successive positions.
/// Source: von Neumann (1941) Ann Math Statist 12:367-395.
double successive_noise_mm(const std::vector<Eigen::Vector3d>& places)
{
  double sum_sq = 0.0;
  for (std::size_t k = 1; k < places.size(); ++k) sum_sq += (places[k] - places[k - 1]).squaredNorm();
  return places.size() < 2 ? 0.0 : std::sqrt(0.5 * sum_sq / static_cast<double>(places.size() - 1));
}

}  // namespace

void require_static(CalibrationPart part, const Task& task, const CalibrationMark& mark,
                    const std::string& path)
{
  // Ten times the noise of an optical tracker at the tip of a probe.
  constexpr double least_limit_mm = 3.0;
  std::vector<Eigen::Vector3d> places;
  if (task.kind == TaskKind::bullseye) places = marker_positions(mark);
  if (task.kind == TaskKind::hold) {
    for (const std::vector<double>& row : mark.rows)
      places.push_back(sampled_pose(row, 7).inverse() * sampled_position(row));
  }
  const MeanPosition mean = mean_position(places);
  // The noise of a static tool is as large between successive samples as about their mean; a motion is not.
  constexpr double most_deviations = 3.0;
  const double furthest_mm = std::max(least_limit_mm, most_deviations * successive_noise_mm(places));
  if (mean.furthest_mm > furthest_mm) {
    throw PartRefusal(
        {path, std::string(bench::name_of(part)) + ", " + task.name,
         "samples up to " + show::rounded_text(mean.furthest_mm, 1) + " mm from their mean",
         "at most " + show::rounded_text(furthest_mm, 1) + " mm; hold it still and sample again"});
  }
}

std::vector<std::string> result_lines(CalibrationPart part, const bench::Estimate& estimate)
{
  std::vector<std::string> lines{std::string(bench::name_of(part)) + " is done:"};
  for (Eigen::Index k = 0; k < estimate.values.size(); ++k)
    lines.push_back(estimate.names[static_cast<std::size_t>(k)] + " " +
                    bench::interval_text(estimate, k));
  if (!estimate.residuals.empty()) {
    lines.push_back("residual " + show::rounded_text(estimate.residual_rms, 3) + " " +
                    estimate.residual_unit + " (root mean square)");
  }
  lines.insert(lines.end(), estimate.remarks.begin(), estimate.remarks.end());
  return lines;
}

Calibration solve_again(const BenchFile& bench, const Calibration& calibration, const std::string& path)
{
  Calibration solved = calibration;
  const PartInput in{bench, solved, path};
  const auto has_estimate = [&](CalibrationPart below) { return find_estimate(solved, below) != nullptr; };
  for (const CalibrationPart part : parts_of(bench)) {
    if (!solved.records.contains(part) || solved.records[part].marks.empty()) continue;
    CalibrationRecord& record = solved.records[part];
    update_made_with(record, part, bench);
    // Dependent parts also read the marks of an unsolved part.
    require_current_record(part, in);
    // A dependency without an estimate is being repeated.
    const std::vector<CalibrationPart> below = dependencies_of(part, bench);
    if (!std::ranges::all_of(below, has_estimate)) continue;
    const std::vector<Task> tasks = tasks_of(part, bench, solved);
    if (next_task(tasks, record) < tasks.size()) continue;
    solved = solve_part(part, in);
  }
  return solved;
}

}  // namespace vrda::calibration
