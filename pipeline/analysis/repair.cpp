#include "analysis/repair.hpp"

#include <Eigen/Geometry>
#include <boost/math/statistics/univariate_statistics.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "solve/sweep.hpp"
#include "store/solved_cells.hpp"

namespace vrda::analysis {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
// Distance at which surfaces are kept apart: above the rounding of poses (1e-12 mm) and the last steps'
// curvature, far below repair_tolerance_mm.
constexpr double margin_mm = 5e-4;
// Limits count as met, and the iteration as converged, below these. The step is in units of the noise.
constexpr double met_mm = 5e-4, ended = 1e-3;
constexpr int most_repair_steps = 60;
// A step moves no point of the moving object further: features are found within some tenths of a mm.
constexpr double longest_step_mm = 1.5;
// Steps to the nearest permitted pose of each frame alone, after the last programme.
constexpr int most_corrections = 10;
// Displacements below this (units of the noise) are rounding: the measured pose is kept.
constexpr double negligible = 1e-9;

double radius_mm(const Mesh& mesh)
{
  return mesh.vertices_mm.rows() == 0 ? 0.0 : mesh.vertices_mm.rowwise().norm().maxCoeff();
}

class Repair {
 public:
  Repair(const AuditScene& scene, const MeasuredMotion& measured, const RepairOptions& options)
      : scene_(scene),
        measured_(measured),
        key_(measured.key),
        options_(options),
        scale_(noise_scale(scene.frame, options.noise)),
        radius_mm_(radius_mm(scene.moving.mesh())),
        twist_(measured.key.size(), Vector6d::Zero()),
        known_(measured.key.size()),
        step_(measured.key.size(), Vector6d::Zero()),
        most_mm_(measured.key.size(), longest_step_mm),
        contact_(measured.key.size())
  {
    for (const Pose& X : measured.X_reference_moving)
      X_measured_.push_back(X_solver_reference_moving(scene.frame, X));
    X_ = X_measured_;
    weights_ = weights();
  }

  RepairedMotion run()
  {
    sample();
    set_gap_limits();
    while (out_.n_iterations < most_repair_steps && !out_.is_converged) {
      const double change = advance(minimise(programme(weights_, Origin::measured)));
      ++out_.n_iterations;
      out_.is_converged = change <= ended && largest_excess_mm() <= met_mm;
    }
    for (int k = 0; k < most_corrections && largest_excess_mm() > met_mm; ++k)
      advance(minimise(programme(Vector6d::Zero(), Origin::current)));
    for (Eigen::Index c = 0; c < 6; ++c) out_.period_frames(c) = period_of_weight(weights_(c));
    out_.frames.resize(X_.size());
    for_each_index(X_.size(), options_.n_threads, [this] {
      return [this, meter = PoseMeter(scene_)](std::size_t k) mutable { finish(k, meter); };
    });
    return std::move(out_);
  }

 private:
  enum class Origin : std::int8_t { measured, current };

  Vector6d weights() const
  {
    switch (options_.smoothing) {
      case Smoothing::none:
        break;
      case Smoothing::from_noise:
        return weights_from_noise(key_, X_measured_, scale_);
      case Smoothing::of_period:
        return Vector6d::Constant(weight_of_period(options_.period_frames));
    }
    return Vector6d::Zero();
  }

  void sample()
  {
    for_each_index(X_.size(), options_.n_threads, [this] {
      return [this, sampler = ContactSampler(scene_)](std::size_t k) mutable {
        contact_[k] = sampler.sample(X_[k], known_[k]);
      };
    });
  }

  // The gradient over the twist, in units of the noise.
  Vector6d over_twist(std::size_t k, const Vector6d& gradient) const
  {
    Vector6d out;
    out << turn_per_twist(twist_[k], scale_).transpose() * gradient.head<3>(),
        scale_.translation.transpose() * gradient.tail<3>();
    return out;
  }

  void set_gap_limits()
  {
    const std::size_t n_sides = contact_.front().travels.size();
    out_.gap_limit_mm.assign(n_sides,
                             options_.gap_limit == GapLimit::of_length ? options_.gap_limit_mm : unlimited);
    if (options_.gap_limit != GapLimit::from_measurement) return;
    for (std::size_t side = 0; side < n_sides; ++side) {
      std::vector<MeasuredGap> gaps;
      for (std::size_t k = 0; k < contact_.size(); ++k) {
        const Measure& travel = contact_[k].travels[side];
        if (std::isfinite(travel.mm)) gaps.push_back({travel.mm, over_twist(k, travel.gradient).norm()});
      }
      out_.gap_limit_mm[side] = supported_gap_mm(gaps);
    }
  }

  // A contact needs room for the margin of a steep face.
  double allowed_mm(std::size_t side, const Measure& travel) const
  {
    const double per_mm = travel.gradient.tail<3>().norm();
    return std::max(out_.gap_limit_mm[side], 3.0 * margin_mm * std::max(1.0, per_mm));
  }

  double largest_excess_mm() const
  {
    double worst = 0.0;
    for (const FrameContact& contact : contact_) {
      for (const Measure& separation : contact.separations) worst = std::max(worst, -separation.mm);
      for (std::size_t side = 0; side < contact.travels.size(); ++side) {
        const Measure& travel = contact.travels[side];
        if (std::isfinite(travel.mm)) worst = std::max(worst, travel.mm - allowed_mm(side, travel));
      }
    }
    return worst;
  }

  std::vector<FrameBound> bounds(std::size_t k) const
  {
    std::vector<FrameBound> out;
    const FrameContact& contact = contact_[k];
    for (const Measure& separation : contact.separations) {
      const Vector6d normal = over_twist(k, separation.gradient);
      out.push_back({normal, margin_mm - separation.mm + normal.dot(twist_[k])});
    }
    for (std::size_t side = 0; side < contact.travels.size(); ++side) {
      const Measure& travel = contact.travels[side];
      if (!std::isfinite(travel.mm) || std::isinf(out_.gap_limit_mm[side])) continue;
      const Vector6d normal = -over_twist(k, travel.gradient);
      out.push_back({normal, travel.mm - allowed_mm(side, travel) + normal.dot(twist_[k])});
    }
    return out;
  }

  SequenceProgram programme(const Vector6d& weights, Origin origin) const
  {
    const std::size_t n = X_.size();
    SequenceProgram out;
    out.H.assign(n, {Matrix6d::Identity(), Matrix6d::Zero(), Matrix6d::Zero()});
    out.b.assign(n, Vector6d::Zero());
    for (std::size_t k = 0; k < n; ++k) {
      out.bounds.push_back(bounds(k));
      if (origin == Origin::current) out.b[k] = twist_[k];
    }
    if (weights.isZero(0.0)) return out;
    for (const SecondDifference& d : second_differences(key_, X_, twist_, scale_)) {
      Vector6d at_zero = d.value;
      for (std::size_t i = 0; i < 3; ++i) at_zero -= d.jacobian[i] * twist_[d.frame - 1 + i];
      for (std::size_t i = 0; i < 3; ++i) {
        const Matrix6d weighted = d.jacobian[i].transpose() * weights.asDiagonal();
        out.b[d.frame - 1 + i] -= weighted * at_zero;
        for (std::size_t j = 0; j <= i; ++j) out.H[d.frame - 1 + i][i - j] += weighted * d.jacobian[j];
      }
    }
    return out;
  }

  // Steps towards `target`; returns the largest change of a frame in units of the noise.
  double advance(const std::vector<Vector6d>& target)
  {
    double largest = 0.0;
    for (std::size_t k = 0; k < target.size(); ++k) {
      Vector6d step = target[k] - twist_[k];
      const double moves_mm = (scale_.rotation * step.head<3>()).norm() * radius_mm_ +
                              (scale_.translation * step.tail<3>()).norm();
      // A frame whose step reverses is at an edge: shorter steps converge to it.
      most_mm_[k] = step.dot(step_[k]) < 0.0 ? 0.5 * std::min(most_mm_[k], moves_mm)
                                             : std::min(2.0 * most_mm_[k], longest_step_mm);
      if (moves_mm > most_mm_[k]) step *= most_mm_[k] / moves_mm;
      twist_[k] += step;
      step_[k] = step;
      largest = std::max(largest, step.norm());
      X_[k] = displaced(X_measured_[k], twist_[k], scale_);
    }
    sample();
    return largest;
  }

  void finish(std::size_t k, PoseMeter& meter)
  {
    RepairedFrame& frame = out_.frames[k];
    frame.at = solve::solver_position(X_measured_[k]);
    frame.X_reference_moving = measured_.X_reference_moving[k];
    frame.before = frame.after = measurement(frame, meter);
    const bool is_moved = twist_[k].cwiseAbs().maxCoeff() > negligible;
    if (is_moved) {
      frame.at = solve::solver_position(X_[k]);
      frame.X_reference_moving = X_reference_moving(scene_.frame, frame.at.attitude, frame.at.pose);
      frame.after = measurement(frame, meter);
      frame.displacement = twist_[k];
    }
    frame.status = status(k, is_moved);
  }

  static FrameMeasurement measurement(const RepairedFrame& frame, PoseMeter& meter)
  {
    return {meter.measure(frame.at.attitude, frame.X_reference_moving, OverlapTest::narrow_phase),
            meter.compartment_gaps(frame.at.attitude, frame.X_reference_moving)};
  }

  FrameStatus status(std::size_t k, bool is_moved) const
  {
    const FrameContact& contact = contact_[k];
    bool is_met = out_.frames[k].after.audit.penetration_mm <= repair_tolerance_mm;
    for (std::size_t side = 0; side < contact.travels.size(); ++side) {
      const Measure& travel = contact.travels[side];
      is_met = is_met && (std::isinf(travel.mm) || std::isinf(out_.gap_limit_mm[side]) ||
                          travel.mm <= allowed_mm(side, travel) + repair_tolerance_mm);
    }
    if (!is_met) return FrameStatus::not_converged;
    if (std::isinf(contact.least_travel_mm)) return FrameStatus::nothing_ahead;
    return is_moved ? FrameStatus::repaired : FrameStatus::unchanged;
  }

  const AuditScene& scene_;
  const MeasuredMotion& measured_;
  const std::vector<double>& key_;
  const RepairOptions& options_;
  NoiseScale scale_;
  double radius_mm_ = 0.0;
  Vector6d weights_ = Vector6d::Zero();
  std::vector<Pose> X_measured_, X_;  // moving to reference, S at zero attitude
  std::vector<Vector6d> twist_;
  std::vector<FrameFeatures> known_;
  std::vector<Vector6d> step_;   // the last one
  std::vector<double> most_mm_;  // longest next step
  std::vector<FrameContact> contact_;
  RepairedMotion out_;
};

}  // namespace

const char* name_of(FrameStatus status)
{
  constexpr const char* names[] = {"unchanged", "repaired", "not_converged", "nothing_ahead"};
  return names[static_cast<std::size_t>(status)];
}

RepairedMotion repair(const AuditScene& scene, const MeasuredMotion& measured, const RepairOptions& options)
{
  require_repairable(measured, options);
  return Repair(scene, measured, options).run();
}

namespace {

solve::Joint joint_of(const store::MotionModel& model, const SolverFrame& frame)
{
  std::vector<Compartment> compartments;
  for (const std::int8_t code : model.compartment_of_triangle)
    compartments.push_back(static_cast<Compartment>(code));
  return solve::make_joint(
      {solver_mesh(model.reference.contact.mesh, frame), model.reference.contact.component},
      {solver_mesh(model.moving.contact.mesh, frame), model.moving.contact.component}, compartments);
}

void append(std::vector<double>& rows, const Eigen::Vector3d& v)
{
  rows.insert(rows.end(), {v.x(), v.y(), v.z()});
}

std::vector<double> values_of(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

double free_gap_mm(const PoseAudit& audit)
{
  return audit.is_overlapping || std::isinf(audit.gap_mm) ? nan : audit.gap_mm;
}

store::RepairedFrames rows_of(const MeasuredMotion& measured, const RepairedMotion& motion,
                              const MeasurementNoise& noise)
{
  store::RepairedFrames out;
  out.is_converged = motion.is_converged;
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const RepairedFrame& frame = motion.frames[k];
    for (Eigen::Index i = 0; i < 16; ++i)
      out.X_measured.push_back(measured.X_reference_moving[k].matrix()(i / 4, i % 4));
    out.status.push_back(static_cast<std::int8_t>(frame.status));
    out.distance.push_back(frame.displacement.norm());
    append(out.rotation_shift, frame.displacement.head<3>());
    append(out.translation_shift, frame.displacement.tail<3>());
    out.gap_before_mm.push_back(free_gap_mm(frame.before.audit));
    out.gap_after_mm.push_back(free_gap_mm(frame.after.audit));
    out.penetration_before_mm.push_back(frame.before.audit.penetration_mm);
    out.penetration_after_mm.push_back(frame.after.audit.penetration_mm);
  }
  for (Eigen::Index k = 0; k < 3; ++k) out.noise_deg.push_back(deg_from_rad(noise.rotation_rad(k)));
  out.noise_mm = values_of(noise.translation_mm);
  out.rotation_period = values_of(motion.period_frames.head<3>());
  out.translation_period = values_of(motion.period_frames.tail<3>());
  for (const double limit_mm : motion.gap_limit_mm)
    out.gap_limit_mm.push_back(std::isinf(limit_mm) ? nan : limit_mm);
  return out;
}

}  // namespace

MeasuredMotion measured_motion(const store::MotionModel& model, const std::string& file)
{
  if (!model.frames)
    throw InputError({file, "/frame", "a grid of attitudes", "a sequence of frames, e.g. of vrda import"});
  MeasuredMotion out;
  out.name = file;
  out.key = model.frames->key;
  for (std::size_t k = 0; k < out.key.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const std::string frame = "frame " + std::to_string(k + 1);
    if (model.status(row, 0) != store::code_of(StepStatus::stable))
      throw InputError({file, frame, "no pose", "a pose in every frame"});
    if (model.push.delta.row(row) != model.push.delta.row(0))
      throw InputError({file, "/push/delta of " + frame, "another direction", "one Delta for all frames"});
    out.X_reference_moving.push_back(model.repair ? store::pose_in(model.repair->X_measured, k)
                                                  : store::pose_in(model.X_reference_moving, k));
  }
  return out;
}

AuditScene scene_of(const store::MotionModel& model)
{
  return make_audit_scene(model.reference.contact.mesh, model.moving.contact.mesh,
                          store::solver_frame(model, 0), model.compartment_of_triangle);
}

store::MotionModel repaired_model(const store::MotionModel& model, const MeasuredMotion& measured,
                                  const RepairedMotion& motion, const MeasurementNoise& noise)
{
  store::MotionModel out = model;
  for (std::size_t k = 0; k < motion.frames.size(); ++k)
    out.flexion_deg[k] = deg_from_rad(motion.frames[k].at.attitude.flexion_rad);
  out.ligaments.reset();
  const store::PushRows push = out.push;
  out = store::with_pending_cells(std::move(out));
  out.push = push;
  const solve::Joint joint = joint_of(out, store::solver_frame(out, 0));
  FrameMeter meter(joint, out.contact_resolution_mm);
  std::vector<StepRecord> cells;
  for (std::size_t k = 0; k < motion.frames.size(); ++k) {
    const RepairedFrame& frame = motion.frames[k];
    cells.push_back(meter.record(static_cast<std::int32_t>(k), frame.at, frame.after.compartments));
    store::set_cell(out, cells.back());
    out.is_spine(static_cast<Eigen::Index>(k), 0) = 1;
  }
  out.contacts = store::contact_rows(out, cells);
  if (out.has_compartments) out.contact_paths = store::contact_paths_of(out);
  out.repair = rows_of(measured, motion, noise);
  return out;
}

namespace {

// Matrix elements of tables have six digits or more.
constexpr double rigid_tolerance = 1e-5;
// Standard deviation of a normal number over its median absolute deviation.
constexpr double normal_scale = 1.4826022185056018;

std::string text_of(double value)
{
  return shortest_decimal(value);
}

std::string frame_of(const MeasuredMotion& measured, std::size_t k)
{
  return "frame " + std::to_string(k + 1) + " (key " + text_of(measured.key[k]) + ")";
}

void require_noise(const MeasuredMotion& measured, const char* field, const Eigen::Vector3d& deviation,
                   double unit)
{
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (deviation(k) >= 0.0 && std::isfinite(deviation(k))) continue;
    throw InputError({measured.name, field, text_of(deviation(k) / unit), "a finite number, at least 0"});
  }
}

void require_options(const MeasuredMotion& measured, const RepairOptions& options)
{
  require_noise(measured, "--noise-deg", options.noise.rotation_rad, rad_from_deg(1.0));
  require_noise(measured, "--noise-mm", options.noise.translation_mm, 1.0);
  if (options.noise.rotation_rad.isZero(0.0) && options.noise.translation_mm.isZero(0.0)) {
    throw InputError(
        {measured.name, "--noise-mm, --noise-deg", "no noise",
         "standard deviations of the measured translations and rotations; at least one above 0"});
  }
  if (options.smoothing == Smoothing::of_period &&
      !(options.period_frames > 2.0 && std::isfinite(options.period_frames)))
    throw InputError({measured.name, "--smooth", text_of(options.period_frames), "more than 2 frames"});
  if (options.gap_limit == GapLimit::of_length &&
      !(options.gap_limit_mm >= 0.0 && std::isfinite(options.gap_limit_mm)))
    throw InputError(
        {measured.name, "--gap-mm", text_of(options.gap_limit_mm), "a finite number, at least 0"});
}

void require_pose(const MeasuredMotion& measured, std::size_t k)
{
  const Pose& X = measured.X_reference_moving[k];
  if (!X.matrix().allFinite())
    throw InputError(
        {measured.name, frame_of(measured, k), "a pose that is not finite", "12 finite numbers"});
  const Eigen::Matrix3d R = X.linear();
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const double volume = R.col(0).cross(R.col(1)).dot(R.col(2));
  if (error > rigid_tolerance || volume < 0.0)
    throw InputError({measured.name, frame_of(measured, k), "a matrix that is not a rotation",
                      "an orthogonal matrix with determinant 1"});
}

double squared(double value)
{
  return value * value;
}

// Standard deviation about `middle` of normal numbers, from the median absolute deviation.
double spread_of(std::vector<double> values, double middle)
{
  for (double& value : values) value = std::abs(value - middle);
  return normal_scale * boost::math::statistics::median(values);
}

}  // namespace

void require_repairable(const MeasuredMotion& measured, const RepairOptions& options)
{
  require_options(measured, options);
  check(measured.key.size() == measured.X_reference_moving.size(), "one key a pose");
  if (measured.key.empty()) throw InputError({measured.name, "frames", "none", "at least one"});
  for (std::size_t k = 0; k < measured.key.size(); ++k) {
    if (!std::isfinite(measured.key[k]))
      throw InputError({measured.name, "key of frame " + std::to_string(k + 1), text_of(measured.key[k]),
                        "a finite number"});
    if (k > 0 && measured.key[k] <= measured.key[k - 1])
      throw InputError({measured.name, "key of frame " + std::to_string(k + 1), text_of(measured.key[k]),
                        "a number above " + text_of(measured.key[k - 1])});
    require_pose(measured, k);
    if (k == 0) continue;
    const Eigen::Matrix3d turn = Eigen::Matrix3d(measured.X_reference_moving[k].linear()) *
                                 measured.X_reference_moving[k - 1].linear().transpose();
    if (turn.trace() > 1.0) continue;  // 1 + 2 cos
    throw InputError({measured.name, frame_of(measured, k), "a rotation of 90 degrees or more since the last",
                      "less between neighbouring frames"});
  }
}

double supported_gap_mm(const std::vector<MeasuredGap>& gaps)
{
  if (gaps.empty()) return std::numeric_limits<double>::infinity();
  std::vector<double> values, differences;
  double noise_sq_mm2 = 0.0;
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    values.push_back(gaps[k].mm);
    noise_sq_mm2 += gaps[k].noise_mm * gaps[k].noise_mm / static_cast<double>(gaps.size());
    if (k >= 2) differences.push_back(gaps[k].mm - 2.0 * gaps[k - 1].mm + gaps[k - 2].mm);
  }
  // Independent errors have second differences with six times their variance; a gap that changes smoothly has
  // smaller ones, and its change is real.
  if (!differences.empty()) noise_sq_mm2 = std::min(noise_sq_mm2, squared(spread_of(differences, 0.0)) / 6.0);
  const double middle = boost::math::statistics::median(values);
  const double real_sq_mm2 = squared(spread_of(values, middle)) - noise_sq_mm2;
  return std::max(0.0, middle) + 2.0 * std::sqrt(std::max(0.0, real_sq_mm2));
}

namespace {

// Features up to a band beyond the nearest are constraints; contacts beyond the band are found in the next
// step. Six are active at most; congruent surfaces have thousands within tenths of a mm, which would be slow.
constexpr double least_band_mm = 1e-3, largest_band_mm = 0.3;
constexpr std::size_t few_features = 20, most_features = 60;
// Features of earlier steps are kept for some steps, so that the solution does not alternate between two
// features; older ones would be planes of faces that are no longer near.
constexpr int most_age = 3;
// Features further apart cannot be active after the next step.
constexpr double far_mm = 1.0;

constexpr double no_contact = std::numeric_limits<double>::infinity();

// Unit normal (reaction on the moving object) in S, and its derivative over a left rotation of the pose.
struct Normal {
  Eigen::Vector3d n;
  Eigen::Matrix3d change;
};

Normal normal_of(const FeatureConstraint& feature, const Eigen::Matrix3d& R)
{
  const solve::ContactConstraint& contact = feature.contact;
  const Eigen::Vector3d of_reference = contact.reference_direction, of_moving = R * contact.moving_direction;
  switch (contact.kind) {
    case solve::ContactConstraint::Kind::face_of_reference:
      return {of_reference, Eigen::Matrix3d::Zero()};
    case solve::ContactConstraint::Kind::face_of_moving:
      return {of_moving, -cross_matrix(of_moving)};
    default:
      break;
  }
  const Eigen::Vector3d across = feature.sign * of_reference.cross(of_moving);
  const double length = across.norm();
  const Eigen::Vector3d n = across / length;
  const Eigen::Matrix3d raw = -feature.sign * (cross_matrix(of_reference) * cross_matrix(of_moving));
  return {n, (raw - n * (n.transpose() * raw)) / length};
}

// The force acts at the nearest points; Delta turns with the moving object.
FeatureMeasure measured_rounded(const solve::ContactConstraint& contact, const Pose& X)
{
  const Eigen::Matrix3d R = X.linear();
  const Eigen::Vector3d delta = R.col(1);
  const solve::PlacedConstraint placed{
      contact.kind,          contact.offset_mm,           contact.reference_mm,
      X * contact.moving_mm, contact.reference_direction, R * contact.moving_direction};
  const solve::RoundedContact near = solve::rounded_distance(placed, delta);
  const solve::RoundedContact touch = solve::rounded_travel(placed, delta);
  FeatureMeasure out;
  out.separation = {near.mm, Vector6d::Zero()};
  out.travel = {touch.mm, Vector6d::Zero()};
  if (std::isfinite(near.mm))
    out.separation.gradient << (near.moving_mm - X.translation()).cross(near.normal), near.normal;
  if (!std::isfinite(touch.mm)) return out;
  const Eigen::Vector3d arm = touch.moving_mm - X.translation() + touch.mm * delta;
  out.travel.gradient << arm.cross(touch.normal), touch.normal;
  out.travel.gradient /= -touch.normal.dot(delta);
  return out;
}

}  // namespace

FeatureMeasure measured(const FeatureConstraint& feature, const Pose& X)
{
  if (feature.contact.offset_mm > 0.0) return measured_rounded(feature.contact, X);
  const Eigen::Matrix3d R = X.linear();
  const Normal normal = normal_of(feature, R);
  const Eigen::Vector3d arm = R * feature.contact.moving_mm;
  const Eigen::Vector3d apart = X.translation() + arm - feature.contact.reference_mm;
  FeatureMeasure out;
  out.separation.mm = normal.n.dot(apart);
  out.separation.gradient << arm.cross(normal.n) + normal.change.transpose() * apart, normal.n;
  const Eigen::Vector3d delta = R.col(1);
  const double slope = -normal.n.dot(delta);
  out.travel.mm = out.separation.mm / slope;
  Vector6d slope_gradient = Vector6d::Zero();
  slope_gradient.head<3>() = -(normal.change.transpose() * delta) - delta.cross(normal.n);
  out.travel.gradient = (out.separation.gradient - out.travel.mm * slope_gradient) / slope;
  return out;
}

ContactSampler::ContactSampler(const AuditScene& scene)
    : scene_(scene),
      query_(scene.reference_gap, scene.moving_gap),
      compartment_queries_(solve::compartment_queries(scene.reference_gap, scene.compartment_gap))
{
}

FeatureConstraint ContactSampler::constraint_of(const geometry::GapFeature& feature,
                                                const solve::SolverPosition& at) const
{
  const solve::Configuration configuration{at.pose.translation_mm, at.pose.theta_rad, at.attitude.varus_rad};
  const solve::Rotations rotations(configuration, at.attitude.flexion_rad);
  FeatureConstraint out;
  out.contact = solve::contact_constraint_of(feature, {scene_.reference.mesh(), scene_.moving.mesh(), scale_},
                                             configuration, rotations);
  if (out.contact.kind == solve::ContactConstraint::Kind::edges) {
    const Eigen::Vector3d across = (rotations.of_reference * out.contact.reference_direction)
                                       .cross(rotations.of_moving * out.contact.moving_direction);
    out.sign = across.dot(feature.normal) < 0.0 ? -1.0 : 1.0;
  }
  return out;
}

Measure ContactSampler::nearest(geometry::GapQuery& query, const solve::SolverPosition& at, const Pose& X)
{
  query.set_attitude(at.attitude);
  const geometry::GapResult& found = query.features(at.pose, 0.0);
  if (found.features.empty()) return {no_contact, Vector6d::Zero()};
  return measured(constraint_of(found.features.front(), at), X).travel;
}

FrameContact ContactSampler::sample(const Pose& X, FrameFeatures& known)
{
  const solve::SolverPosition at = solve::solver_position(X);
  query_.set_attitude(at.attitude);
  const geometry::GapResult& found = query_.features(at.pose, known.band_mm);
  std::vector<FeatureConstraint> features;
  for (const geometry::GapFeature& feature : found.features) {
    if (features.size() == most_features) break;
    features.push_back(constraint_of(feature, at));
  }
  if (found.features.size() < few_features) known.band_mm = std::min(2.0 * known.band_mm, largest_band_mm);
  if (found.features.size() > most_features) known.band_mm = std::max(0.5 * known.band_mm, least_band_mm);
  const std::size_t n_new = features.size();
  for (FeatureConstraint& old : known.kept) {
    const bool is_found = std::any_of(features.begin(), features.begin() + static_cast<std::ptrdiff_t>(n_new),
                                      [&old](const FeatureConstraint& feature) {
                                        return feature.contact.triangles == old.contact.triangles;
                                      });
    if (!is_found && ++old.age <= most_age) features.push_back(old);
  }
  FrameContact out;
  out.least_travel_mm = found.features.empty() ? no_contact : found.features.front().travel_mm;
  known.kept.clear();
  for (const FeatureConstraint& feature : features) {
    const FeatureMeasure at_pose = measured(feature, X);
    if (feature.age > 0 && !(at_pose.separation.mm < far_mm)) continue;
    out.separations.push_back(at_pose.separation);
    known.kept.push_back(feature);
  }
  if (scene_.has_compartments()) {
    for (geometry::GapQuery& query : compartment_queries_) out.travels.push_back(nearest(query, at, X));
  } else {
    out.travels = {known.kept.empty() || found.features.empty() ? Measure{no_contact, Vector6d::Zero()}
                                                                : measured(known.kept.front(), X).travel};
  }
  return out;
}

}  // namespace vrda::analysis
