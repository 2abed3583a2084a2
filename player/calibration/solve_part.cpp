#include "calibration/solve_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/eyes_fit.hpp"
#include "calibration/fiducial_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/session.hpp"
#include "calibration/task.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "show/session.hpp"

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
                               " mm, of the eyes " + show::rounded_text(ipd_mm, 1) + " mm: adjust the arms");
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
    lines.push_back(estimate.names[static_cast<std::size_t>(k)] + " " + bench::interval_text(estimate, k));
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

// Solves the calibration's parts of the display: edges, distortion, eye point.

namespace {

std::vector<MarkedTask> tasks_of_eye(CalibrationPart part, const PartInput& in, bool is_right)
{
  std::vector<MarkedTask> tasks = marked_tasks(part, in);
  std::erase_if(tasks, [&](const MarkedTask& t) { return t.task.is_right != is_right || t.mark == nullptr; });
  return tasks;
}

}  // namespace

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

std::vector<std::string> names_of(std::span<const MarkedTask> tasks)
{
  std::vector<std::string> names;
  for (const MarkedTask& t : tasks) names.push_back(t.task.name);
  return names;
}

bench::Estimate solve_viewport(const PartInput& in, bool is_right)
{
  calibration::ViewportMarks marks;
  marks.screen_sd_mm = in.bench.calibration.screen_sd_mm;
  std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::viewport, in, is_right);
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
  const view::Viewport& window = view::side_of(in.bench.display.windows, is_right);
  return run_fit(names_of(tasks),
                 [&] { return calibration::fit_viewport(marks, window, side_name(is_right), in.path); });
}

calibration::DistortionFit solve_distortion(const PartInput& in, bool is_right)
{
  const view::EyePair eyes = eyes_before(CalibrationPart::distortion, in);
  const std::string name = side_name(is_right);
  const bench::Estimate& viewport = estimate_of(CalibrationPart::viewport, in);
  const std::string aspect = name + ".pixel_aspect";
  const calibration::AspectPrior prior{value_in(viewport, aspect),
                                       std::sqrt(prior_covariance(viewport, {aspect})(0, 0))};
  std::vector<calibration::GridMark> nodes;
  const CalibrationSettings& settings = in.bench.calibration;
  calibration::AdjustedGrids grids{{}, settings.grid_columns, settings.grid_rows};
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::distortion, in, is_right);
  for (const MarkedTask& t : tasks) {
    const std::vector<double>& v = t.mark->rows[0];
    if (t.task.kind == TaskKind::point) {
      nodes.push_back({t.task.node, {v[0], v[1]}});
    } else {
      grids.values.push_back({v[0], v[1], {v[2], v[3]}, {{v[4], v[5]}, v[6], v[7]}});
    }
  }
  const view::Eye& eye = view::side_of(eyes, is_right);
  return run_fit(names_of(tasks), [&] {
    return settings.is_grid_adjusted ? calibration::mean_distortion(grids, eye, prior, name, in.path)
                                     : calibration::fit_distortion(nodes, eye, prior, name, in.path);
  });
}

std::vector<calibration::RectangleMark> rectangles_of(const CalibrationSettings& settings)
{
  std::vector<calibration::RectangleMark> marks;
  for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
    for (const CalibrationRectangle& r : settings.rectangles)
      marks.push_back({r.width_mm, r.depth_mm, Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()});
  }
  return marks;
}

calibration::EyeRectangles solve_eye_rectangles(const PartInput& in, bool is_right)
{
  const CalibrationSettings& settings = in.bench.calibration;
  calibration::EyeRectangles found;
  const view::EyePair eyes = eyes_before(CalibrationPart::eyepoints, in);
  found.eye = view::side_of(eyes, is_right);
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::eyepoints, in, is_right);
  for (const MarkedTask& t : tasks) {
    const CalibrationRectangle& r = settings.rectangles[static_cast<std::size_t>(t.task.index)];
    const std::vector<double>& v = t.mark->rows[0];
    found.marks.push_back({r.width_mm, r.depth_mm, {v[0], v[1]}, {v[2], v[3]}});
  }
  calibration::EyepointOptions options;
  options.alignment_sd_rad = settings.alignment_sd_rad;
  options.distortion_covariance =
      prior_covariance(estimate_of(CalibrationPart::distortion, in), distortion_names(is_right));
  found.fit = run_fit(names_of(tasks), [&] {
    return calibration::fit_eyepoint(found.marks, found.eye, options, side_name(is_right), in.path);
  });
  return found;
}

// Solves the optional part functional: the model placed in thigh and shank by the motion of the leg.

namespace {

/// Everything that calibration::FunctionalInput refers to.
struct FunctionalData {
  std::vector<std::string> tasks;
  std::vector<calibration::FlexionTrial> trials;
  calibration::JointCurve curve;
  calibration::BonePlacement femur, tibia;
  bench::FunctionalSettings settings;

  calibration::FunctionalInput input() const { return {trials, curve, femur, tibia, settings}; }
};

calibration::BonePlacement placement_of(CalibrationPart part, const PartInput& in)
{
  const bench::Estimate& estimate = estimate_of(part, in);
  const std::string name = bench::name_of(part);
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Ones();
  unit.tail<3>().setConstant(rad_from_deg(1.0));
  const calibration::Matrix6 covariance = prior_covariance(estimate, bench::pose_number_names(name));
  return {pose_in(estimate, name), unit.asDiagonal() * covariance * unit.asDiagonal()};
}

calibration::FlexionTrial trial_of(const CalibrationMark& mark)
{
  calibration::FlexionTrial trial{mark.task, {}};
  for (const std::vector<double>& row : mark.rows)
    trial.X_thigh_shank.push_back(sampled_pose(row).inverse() * sampled_pose(row, 7));
  return trial;
}

/// Of the trials with marks.
FunctionalData data_of(const PartInput& in)
{
  FunctionalData data;
  const CalibrationRecord& record = in.begun.records.at(CalibrationPart::functional);
  for (const CalibrationMark& mark : record.marks) {
    data.tasks.push_back(mark.task);
    data.trials.push_back(trial_of(mark));
  }
  const bench::Estimate* subject = find_estimate(in.begun, CalibrationPart::subject);
  const double scale = subject == nullptr ? in.begun.subject_scale : value_in(*subject, "subject.scale");
  data.curve = calibration::scaled(
      calibration::joint_curve_of(record.made_with,
                                  bench::record_key(CalibrationPart::functional) + ".made_with", in.path),
      scale);
  data.femur = placement_of(CalibrationPart::femur, in);
  data.tibia = placement_of(CalibrationPart::tibia, in);
  data.settings = in.bench.calibration.functional;
  return data;
}

/// Root mean square distance of the touched targets of both bones, which no fit has used.
double targets_rms_mm(const PartInput& in, const Pose& X_thigh_femur, const Pose& X_shank_tibia)
{
  double sum_sq = 0.0, n = 0.0;
  for (const CalibrationPart part : {CalibrationPart::femur, CalibrationPart::tibia}) {
    const Pose& X = part == CalibrationPart::femur ? X_thigh_femur : X_shank_tibia;
    for (const calibration::Fiducial& point : touched_points(part, in)) {
      if (!point.is_target) continue;
      sum_sq += (X * point.p_model_mm - point.p_body_mm).squaredNorm();
      n += 1.0;
    }
  }
  return n > 0.0 ? std::sqrt(sum_sq / n) : -1.0;
}

}  // namespace

calibration::FunctionalFit solve_functional(const PartInput& in)
{
  const FunctionalData data = data_of(in);
  calibration::FunctionalFit fit =
      run_fit(data.tasks, [&] { return calibration::fit_functional(data.input(), in.path); });
  if (in.bench.calibration.is_model_adjusted) return fit;
  const double after_mm = targets_rms_mm(in, fit.X_thigh_femur, fit.X_shank_tibia);
  if (after_mm >= 0.0) {
    const double before_mm = targets_rms_mm(in, data.femur.X_body_bone, data.tibia.X_body_bone);
    fit.estimate.remarks.push_back("the targets fit to " + bench::text(after_mm, 2, "mm") +
                                   " (rms), with landmarks alone to " + bench::text(before_mm, 2, "mm"));
  }
  return fit;
}

std::vector<std::string> bend_remarks(const Task& done, const PartInput& in)
{
  const FunctionalData data = data_of(in);
  const calibration::FlexionTrial trial =
      trial_of(*find_mark(in.begun.records.at(CalibrationPart::functional), done.name));
  const double range_rad = calibration::flexion_range_rad(trial, data.input());
  const std::string found = "a flexion range of " + bench::text(deg_from_rad(range_rad), 0, "degrees");
  if (range_rad < calibration::least_flexion_range_rad) {
    throw PartRefusal(
        {in.path, "functional, " + done.name, found,
         bench::text(deg_from_rad(calibration::least_flexion_range_rad), 0, "degrees") +
             " or more within the model's range; a smaller motion does not determine the joint"},
        {done.name});
  }
  return {done.name + ": " + found};
}

// Solves the parts of the calibration that determine poses: table, probe, eyes in the head, model on the leg.

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Task names in the order of Rail.
const std::vector<std::string> rails{"x rail", "z rail"};

const CalibrationMark& mark_named(CalibrationPart part, const PartInput& in, const std::string& task)
{
  const CalibrationMark* mark = find_mark(in.begun.records.at(part), task);
  check(mark != nullptr, "a part is solved when all its tasks are done");
  return *mark;
}

calibration::RailSweep sweep_of(const CalibrationMark& mark, bool is_on_stage)
{
  constexpr std::size_t stage_at = 7;
  calibration::RailSweep sweep;
  for (const std::vector<double>& row : mark.rows) {
    sweep.p_tracker_mm.push_back(sampled_position(row));
    if (is_on_stage && row.size() > stage_at) sweep.stage_mm.push_back(row[stage_at]);
  }
  // The stage must be known at all positions or none.
  if (sweep.stage_mm.size() != sweep.p_tracker_mm.size()) sweep.stage_mm.clear();
  return sweep;
}

/// Adds the table's covariance to the pose of the eyes on the table. Bull's-eyes determine the eyes in the
/// tracker frame, so a table error (translation b, rotation a, tracker axes) becomes, with R of
/// X_tracker_table and t of X_table_eyes, the rotation -R^T a and the translation -R^T b - (R^T a) x t. mm
/// and degrees.
void add_table_error(bench::Estimate& eyes, const Pose& X_table_eyes, const Pose& X_tracker_table,
                     const bench::Estimate& table)
{
  const Eigen::Matrix3d R_t = X_tracker_table.linear().transpose();
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = -R_t;
  A.topRightCorner<3, 3>() = rad_from_deg(1.0) * bench::cross_matrix(X_table_eyes.translation()) * R_t;
  A.bottomRightCorner<3, 3>() = -R_t;
  eyes.covariance.topLeftCorner<6, 6>() +=
      A * prior_covariance(table, bench::pose_number_names("table")) * A.transpose();
}

calibration::EyesPrior eyes_prior(const PartInput& in)
{
  const CalibrationSettings& settings = in.bench.calibration;
  calibration::EyesPrior prior;
  prior.eyes = eyes_before(CalibrationPart::bullseye, in);
  prior.eyepoint_covariance =
      prior_covariance(estimate_of(CalibrationPart::eyepoints, in),
                       {"left.distance", "left.depth", "right.distance", "right.depth"});
  prior.ipd_sd_mm = std::sqrt(prior_covariance(estimate_of(CalibrationPart::ipd, in), {"ipd"})(0, 0));
  prior.sight_sd_px = settings.sight_sd_px;
  prior.height_difference_sd_mm = settings.eye_height_sd_mm;
  const bench::Estimate& distortion = estimate_of(CalibrationPart::distortion, in);
  for (const bool is_right : {false, true}) {
    const std::size_t k = is_right ? 1 : 0;
    prior.distortion_covariance[k] = prior_covariance(distortion, distortion_names(is_right));
    prior.eyepoint_distortion_jacobian[k] = solve_eye_rectangles(in, is_right).fit.distortion_jacobian;
  }
  return prior;
}

calibration::BullseyeMark bullseye_of(const MarkedTask& t, const Pose& X_carrier_seen, double stage_mm_is_x)
{
  const std::vector<double>& cross = t.mark->rows[0];
  const MeanPosition mean = mean_position(marker_positions(*t.mark));
  calibration::BullseyeMark mark;
  mark.is_right = t.task.is_right;
  mark.drawn_px = {cross[0], cross[1]};
  mark.p_carrier_mm = X_carrier_seen * mean.p_mm - stage_mm_is_x * cross[2] * Eigen::Vector3d::UnitX();
  mark.p_sd_mm = mean.sd_mm / std::sqrt(static_cast<double>(t.mark->rows.size() - 1));
  return mark;
}

/// Touched points in the body frame and the orientation of the probe.
struct Touched {
  std::vector<calibration::Fiducial> points;
  std::vector<Eigen::Matrix3d> R_body_probe;
};

Touched touched_of(std::span<const MarkedTask> tasks, std::span<const CalibrationPoint> points,
                   const Eigen::Vector3d& tip_probe_mm, double scale)
{
  Touched touched;
  for (const MarkedTask& t : tasks) {
    const CalibrationPoint& point = points[static_cast<std::size_t>(t.task.index)];
    std::vector<Eigen::Vector3d> tips;
    for (const std::vector<double>& row : t.mark->rows)
      tips.push_back(sampled_pose(row, 7).inverse() * (sampled_pose(row) * tip_probe_mm));
    touched.points.push_back(
        {point.name, scale * point.p_model_mm, mean_position(tips).p_mm, point.is_target});
    const std::vector<double>& first = t.mark->rows[0];
    touched.R_body_probe.push_back((sampled_pose(first, 7).inverse() * sampled_pose(first)).linear());
  }
  return touched;
}

/// Adds the covariance from tip and scale errors, by a linear fit of the pose to the displacements that they
/// cause: a tip error displaces each point by the probe's rotation of it, a scale error along the point's
/// position vector.
void add_known_errors(calibration::FiducialFit& fit, const Touched& touched,
                      const Eigen::Matrix3d& tip_covariance, double scale_variance, double scale)
{
  // Least squares of translation + rotation x r = displacement, r from the model's origin to the point in
  // body axes.
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < touched.points.size(); ++k) {
    if (!touched.points[k].is_target) used.push_back(k);
  }
  Matrix6d N = Matrix6d::Zero();
  Eigen::Matrix<double, 6, 3> of_tip = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Matrix<double, 6, 1> of_scale = Eigen::Matrix<double, 6, 1>::Zero();
  for (const std::size_t k : used) {
    const Eigen::Vector3d r = fit.X_body_model.linear() * touched.points[k].p_model_mm;
    Eigen::Matrix<double, 3, 6> G;
    G << Eigen::Matrix3d::Identity(), -bench::cross_matrix(r);
    N += G.transpose() * G;
    of_tip += G.transpose() * touched.R_body_probe[k];
    of_scale += G.transpose() * r / scale;
  }
  const Eigen::LDLT<Matrix6d> solver(N);
  Matrix6d units = Matrix6d::Identity();
  units.bottomRightCorner<3, 3>() *= deg_from_rad(1.0);
  const Eigen::Matrix<double, 6, 3> A = units * solver.solve(of_tip);
  const Eigen::Matrix<double, 6, 1> b = units * solver.solve(of_scale);
  fit.estimate.covariance.topLeftCorner<6, 6>() +=
      A * tip_covariance * A.transpose() + scale_variance * b * b.transpose();
}

/// The probe's tip and the subject's scale.
struct Equipment {
  Eigen::Vector3d tip_probe_mm;
  Eigen::Matrix3d tip_covariance;
  double scale = 1.0, scale_variance = 0.0;
};

Equipment equipment_of(const PartInput& in)
{
  const bench::Estimate& probe = estimate_of(CalibrationPart::probe, in);
  const std::vector<std::string> tip = bench::shared_estimate_names(CalibrationPart::probe);
  Equipment equipment;
  equipment.tip_probe_mm = {value_in(probe, tip[0]), value_in(probe, tip[1]), value_in(probe, tip[2])};
  equipment.tip_covariance = prior_covariance(probe, tip);
  equipment.scale = in.begun.subject_scale;
  if (const bench::Estimate* subject = find_estimate(in.begun, CalibrationPart::subject)) {
    equipment.scale = value_in(*subject, "subject.scale");
    equipment.scale_variance = prior_covariance(*subject, {"subject.scale"})(0, 0);
  }
  return equipment;
}

}  // namespace

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

std::vector<Eigen::Vector3d> marker_positions(const CalibrationMark& mark)
{
  constexpr std::size_t with_head = 10;
  std::vector<Eigen::Vector3d> places;
  for (std::size_t k = 1; k < mark.rows.size(); ++k) {
    const std::vector<double>& row = mark.rows[k];
    const Eigen::Vector3d p = sampled_position(row);
    places.push_back(row.size() == with_head ? Eigen::Vector3d(sampled_pose(row, 3).inverse() * p) : p);
  }
  return places;
}

void require_good_rail(const Task& done, const PartInput& in)
{
  const bool is_x = done.name == rails[0];
  const CalibrationMark& mark = mark_named(CalibrationPart::rails, in, done.name);
  run_fit(rails, [&] {
    calibration::require_valid_rail(sweep_of(mark, is_x && has_stage(in.bench)),
                                    is_x ? calibration::Rail::x : calibration::Rail::z, in.path);
  });
}

calibration::TableFit solve_table(const PartInput& in)
{
  return run_fit(rails, [&] {
    return calibration::fit_table(
        sweep_of(mark_named(CalibrationPart::rails, in, "x rail"), has_stage(in.bench)),
        sweep_of(mark_named(CalibrationPart::rails, in, "z rail"), false), in.path);
  });
}

calibration::PivotFit solve_pivot(const PartInput& in)
{
  std::vector<Pose> places;
  for (const std::vector<double>& row : mark_named(CalibrationPart::probe, in, "sweep").rows)
    places.push_back(sampled_pose(row));
  return run_fit({}, [&] { return calibration::fit_pivot(places, in.path); });
}

calibration::EyesFit solve_eye_pose(CalibrationPart part, const PartInput& in)
{
  const bool is_head = part == CalibrationPart::head;
  const Pose X_tracker_table =
      is_head ? Pose::Identity() : pose_in(estimate_of(CalibrationPart::rails, in), "table");
  std::vector<calibration::BullseyeMark> marks;
  const std::vector<MarkedTask> tasks = marked_tasks(part, in);
  for (const MarkedTask& t : tasks)
    marks.push_back(bullseye_of(t, X_tracker_table.inverse(), is_head ? 0.0 : 1.0));
  const calibration::EyesPrior prior = eyes_prior(in);
  calibration::EyesFit fit = run_fit(names_of(tasks), [&] {
    return calibration::fit_eyes(marks, prior, calibration::initial_eye_pose(marks, prior.eyes),
                                 is_head ? "head" : "eyes", in.path);
  });
  if (!is_head) {
    add_table_error(fit.estimate, fit.X_carrier_eyes, X_tracker_table,
                    estimate_of(CalibrationPart::rails, in));
  }
  return fit;
}

std::vector<calibration::Fiducial> touched_points(CalibrationPart part, const PartInput& in)
{
  const Equipment equipment = equipment_of(in);
  return touched_of(marked_tasks(part, in), points_of(part, in.bench.calibration), equipment.tip_probe_mm,
                    equipment.scale)
      .points;
}

calibration::FiducialFit solve_model_pose(CalibrationPart part, const PartInput& in)
{
  const std::vector<MarkedTask> tasks = marked_tasks(part, in);
  if (in.bench.calibration.is_model_adjusted) {
    std::vector<Pose> places;
    for (const MarkedTask& t : tasks) {
      const std::vector<double>& v = t.mark->rows[0];
      places.push_back(bench::pose_of(bench::PoseParameters{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}));
    }
    return run_fit({},
                   [&] { return calibration::mean_adjusted_pose(places, bench::name_of(part), in.path); });
  }
  const Equipment equipment = equipment_of(in);
  const double scale = equipment.scale, scale_variance = equipment.scale_variance;
  const Touched touched =
      touched_of(tasks, points_of(part, in.bench.calibration), equipment.tip_probe_mm, scale);
  calibration::FiducialFit fit = run_fit(names_of(tasks), [&] {
    return calibration::fit_fiducials(touched.points, bench::name_of(part), in.path, {scale_variance == 0.0});
  });
  add_known_errors(fit, touched, equipment.tip_covariance, scale_variance, scale);
  return fit;
}

}  // namespace vrda::calibration
