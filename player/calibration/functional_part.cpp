// Optional refinement of the placements of both bones by the motion of the leg (thesis 9).
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

struct LegBend final : TaskKind {
  using TaskKind::TaskKind;

  /// From the side: thigh and shank, bent and extended.
  void sketch(Sketch& sketch, const Task&, const BenchFile&) const override
  {
    using enum DiagramInk;
    using Point = Eigen::Vector2d;
    const Point hip(0.15, 0.12), knee(0.5, 0.12);
    sketch.line(real, {hip, knee});
    sketch.circle(plain, knee, 0.025);
    for (const double angle : {0.2, 0.9, 1.6})
      sketch.line(angle == 0.9 ? real : plain, {knee, knee + 0.38 * Point(std::cos(angle), std::sin(angle))});
    sketch.arrow(lit, {0.8, 0.2}, {0.62, 0.44});
    sketch.arrow(lit, {0.8, 0.2}, {0.86, 0.12});
  }

  /// The leg bends from the model's first flexion to about its last one and is stretched again.
  BenchPoses poses(const TaskContext& context, double way) const override
  {
    const VirtualTruth& truth = context.truth;
    check(truth.joint.has_value(), "a virtual leg bends by the motion of a model");
    constexpr double least_share = 0.94;
    RandomSequence draws = draws_of_hand(truth, 1 + bench::n_body_roles, context.task.index);
    const VirtualJoint& joint = *truth.joint;
    const double share = least_share + (1.0 - least_share) * draws.uniform();
    const double bent = 0.5 * share * (1.0 - sin_cos(2.0 * pi * way).cos);
    const double flexion_rad =
        joint.curve.first_rad + bent * (joint.curve.last_rad() - joint.curve.first_rad);
    BenchPoses poses = resting_poses(truth);
    poses.X_tracker_shank = truth.X_tracker_leg * X_body_model(truth.calibration, BodyRole::femur) *
                            joint.X_femur_tibia(flexion_rad) *
                            X_body_model(truth.calibration, BodyRole::tibia).inverse();
    return poses;
  }
};

const LegBend leg_bend({.name = "bend", .samples = TaskKind::Samples::leg});

/// Everything that FunctionalInput refers to.
struct FunctionalData {
  std::vector<std::string> tasks;
  std::vector<FlexionTrial> trials;
  JointCurve curve;
  BonePlacement femur, tibia;
  bench::FunctionalSettings settings;

  FunctionalInput input() const { return {trials, curve, femur, tibia, settings}; }
};

BonePlacement placement_of(CalibrationPart part, const PartInput& in)
{
  const Estimate& estimate = estimate_of(part, in);
  const std::string name = bench::name_of(part);
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Ones();
  unit.tail<3>().setConstant(rad_from_deg(1.0));
  const Matrix6 covariance = prior_covariance(estimate, bench::pose_number_names(name));
  return {pose_in(estimate, name), unit.asDiagonal() * covariance * unit.asDiagonal()};
}

FlexionTrial trial_of(const CalibrationMark& mark)
{
  FlexionTrial trial{mark.task, {}};
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
  const Estimate* subject = find_estimate(in.begun, CalibrationPart::subject);
  const double scale = subject == nullptr ? in.begun.subject_scale : value_in(*subject, "subject.scale");
  data.curve = scaled(joint_curve_of(record.made_with,
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
  for (const BodyRole role : {BodyRole::femur, BodyRole::tibia}) {
    const Pose& X = role == BodyRole::femur ? X_thigh_femur : X_shank_tibia;
    for (const Fiducial& point : touched_points(role, in)) {
      if (!point.is_target) continue;
      sum_sq += (X * point.p_model_mm - point.p_body_mm).squaredNorm();
      n += 1.0;
    }
  }
  return n > 0.0 ? std::sqrt(sum_sq / n) : -1.0;
}

struct FunctionalPart final : Part {
  using Part::Part;

  bool applies_to(const BenchFile& bench) const override { return bench.leg != LegKind::rigid; }

  /// Without a model at hand its record keeps its motion.
  std::optional<std::vector<double>> made_with(const PartInput& in) const override
  {
    if (in.joint == nullptr) return std::nullopt;
    return numbers_of(*in.joint);
  }

  std::string restore_text(const BenchFile&) const override
  {
    return "the model and set with which the part was begun; use them or repeat ";
  }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration&) const override
  {
    const std::optional<bench::BodySettings>& tibia = bench.bodies[BodyRole::tibia];
    std::vector<Task> tasks;
    for (int bend = 0; bend < bench.calibration.bends; ++bend) {
      tasks.push_back(
          {.kind = &leg_bend,
           .name = "bend " + std::to_string(bend + 1),
           .instruction =
               "Stretch the leg and press Enter. Bend it slowly as far as the model reaches and stretch it "
               "again, evenly\n"
               "until sampling is done, without pressing it sideways. Both bodies must be visible and must "
               "not slip.",
           .n_samples = bench.calibration.bend_samples,
           .tool = tibia->tool.empty() ? tibia->markers.front() : tibia->tool,
           .index = bend});
    }
    return tasks;
  }

  void solve(const PartInput& in, Calibration& c) const override
  {
    const FunctionalFit fit = fit_of(in);
    put_model(c, BodyRole::femur, fit.X_thigh_femur);
    put_model(c, BodyRole::tibia, fit.X_shank_tibia);
    c.records.at(id()).estimate = fit.estimate;
  }

  /// Refuses a bend whose range of flexion is too small.
  std::vector<std::string> remarks(const Task& done, const PartInput& in) const override
  {
    const FunctionalData data = data_of(in);
    const FlexionTrial trial =
        trial_of(*find_mark(in.begun.records.at(CalibrationPart::functional), done.name));
    const double range_rad = flexion_range_rad(trial, data.input());
    const std::string found = "a flexion range of " + bench::text(deg_from_rad(range_rad), 0, "degrees");
    if (range_rad < least_flexion_range_rad) {
      throw PartRefusal(
          {in.path, "functional, " + done.name, found,
           bench::text(deg_from_rad(least_flexion_range_rad), 0, "degrees") +
               " or more within the model's range; a smaller motion does not determine the joint"},
          {done.name});
    }
    return {done.name + ": " + found};
  }

 private:
  static FunctionalFit fit_of(const PartInput& in)
  {
    const FunctionalData data = data_of(in);
    FunctionalFit fit = run_fit(data.tasks, [&] { return fit_functional(data.input(), in.path); });
    if (in.bench.calibration.is_model_adjusted) return fit;
    const double after_mm = targets_rms_mm(in, fit.X_thigh_femur, fit.X_shank_tibia);
    if (after_mm >= 0.0) {
      const double before_mm = targets_rms_mm(in, data.femur.X_body_bone, data.tibia.X_body_bone);
      fit.estimate.remarks.push_back("the targets fit to " + bench::text(after_mm, 2, "mm") +
                                     " (rms), with landmarks alone to " + bench::text(before_mm, 2, "mm"));
    }
    return fit;
  }
};

const FunctionalPart functional_object({.id = CalibrationPart::functional,
                                        .group = Part::Group::task,
                                        .is_optional = true,
                                        .bench_key = "the motion of --model",
                                        .below = {CalibrationPart::femur, CalibrationPart::tibia},
                                        .is_made_of_them = true});

}  // namespace

const Part& functional_part = functional_object;

}  // namespace vrda::calibration
