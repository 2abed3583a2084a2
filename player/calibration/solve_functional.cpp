// Solves the optional part functional: the model placed in thigh and shank by the motion of the leg.
#include <cmath>

#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/solve_part.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
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
      calibration::joint_curve_of(
          record.made_with, bench::record_key(CalibrationPart::functional) + ".made_with", in.path),
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
                                   " (rms), with landmarks alone to " +
                                   bench::text(before_mm, 2, "mm"));
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

}  // namespace vrda::calibration
