// Solves the parts of the calibration that determine poses: table, probe, eyes in the head, model on the leg.
#include "calibration/solve_part.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/eyes_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "bench/screw.hpp"

namespace vrda::calibration {
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
    return run_fit(
        {}, [&] { return calibration::mean_adjusted_pose(places, bench::name_of(part), in.path); });
  }
  const Equipment equipment = equipment_of(in);
  const double scale = equipment.scale, scale_variance = equipment.scale_variance;
  const Touched touched = touched_of(tasks, points_of(part, in.bench.calibration), equipment.tip_probe_mm, scale);
  calibration::FiducialFit fit = run_fit(names_of(tasks), [&] {
    return calibration::fit_fiducials(touched.points, bench::name_of(part), in.path,
                                      {scale_variance == 0.0});
  });
  add_known_errors(fit, touched, equipment.tip_covariance, scale_variance, scale);
  return fit;
}

}  // namespace vrda::calibration
