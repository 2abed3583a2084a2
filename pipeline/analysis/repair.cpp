#include "analysis/repair.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "analysis/frame_contact.hpp"
#include "analysis/measured_motion.hpp"
#include "analysis/sequence_program.hpp"
#include "analysis/smoothness.hpp"

namespace vrda::analysis {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
// Distance at which surfaces are kept apart: above the rounding of poses (1e-12 mm) and the last steps'
// curvature, far below repair_tolerance_mm.
constexpr double margin_mm = 5e-4;
// Limits count as met, and the iteration as converged, below these. The step is in units of the noise.
constexpr double met_mm = 5e-4, ended = 1e-3;
constexpr int most_iterations = 60;
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
  Repair(const analysis::AuditScene& scene, const MeasuredMotion& measured, const RepairOptions& options)
      : scene_(scene),
        measured_(measured),
        key_(measured.key),
        options_(options),
        scale_(noise_scale(scene.frame, options.noise)),
        radius_mm_(radius_mm(scene.moving.mesh)),
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
    while (out_.n_iterations < most_iterations && !out_.is_converged) {
      const double change = advance(minimise(programme(weights_, Origin::measured)));
      ++out_.n_iterations;
      out_.is_converged = change <= ended && largest_excess_mm() <= met_mm;
    }
    for (int k = 0; k < most_corrections && largest_excess_mm() > met_mm; ++k)
      advance(minimise(programme(Vector6d::Zero(), Origin::current)));
    for (Eigen::Index c = 0; c < 6; ++c) out_.period_frames(c) = period_of_weight(weights_(c));
    out_.frames.resize(X_.size());
    for_each_index(X_.size(), options_.n_threads, [this] {
      return [this, meter = analysis::PoseMeter(scene_)](std::size_t k) mutable { finish(k, meter); };
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

  void finish(std::size_t k, analysis::PoseMeter& meter)
  {
    RepairedFrame& frame = out_.frames[k];
    const PlacedPose before = placed(X_measured_[k]);
    frame.before = measurement(before.attitude, measured_.X_reference_moving[k], meter);
    const bool is_moved = twist_[k].cwiseAbs().maxCoeff() > negligible;
    const PlacedPose after = is_moved ? placed(X_[k]) : before;
    frame.attitude = after.attitude;
    frame.pose = after.pose;
    frame.X_reference_moving = is_moved ? X_reference_moving(scene_.frame, after.attitude, after.pose)
                                        : measured_.X_reference_moving[k];
    frame.after = is_moved ? measurement(after.attitude, frame.X_reference_moving, meter) : frame.before;
    if (is_moved) frame.displacement = twist_[k];
    frame.status = status(k, is_moved);
  }

  static FrameMeasurement measurement(const Attitude& attitude, const Pose& X, analysis::PoseMeter& meter)
  {
    return {meter.measure(attitude, X, analysis::OverlapTest::narrow_phase),
            meter.compartment_gaps(attitude, X)};
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

  const analysis::AuditScene& scene_;
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
  switch (status) {
    case FrameStatus::unchanged:
      return "unchanged";
    case FrameStatus::repaired:
      return "repaired";
    case FrameStatus::not_converged:
      return "not_converged";
    case FrameStatus::nothing_ahead:
      return "nothing_ahead";
  }
  return "?";
}

RepairedMotion repair(const analysis::AuditScene& scene, const MeasuredMotion& measured,
                      const RepairOptions& options)
{
  require_repairable(measured, options);
  return Repair(scene, measured, options).run();
}

}  // namespace vrda::analysis
