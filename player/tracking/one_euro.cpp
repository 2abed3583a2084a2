#include "tracking/one_euro.hpp"

#include "core/units.hpp"
#include "tracking/screw.hpp"

namespace vrda::tracking {
namespace {

double cutoff_hz(const OneEuroOptions& options, double speed)
{
  return options.least_cutoff_hz + options.hz_by_speed * speed;
}

/// Smoothing factor of a first-order low-pass filter: 1 / (1 + tau / step), tau = 1 / (2 pi cutoff).
double share(double cutoff, double step_s)
{
  return 1.0 / (1.0 + 1.0 / (2.0 * pi * cutoff * step_s));
}

}  // namespace

// A first-order filter y += a (x - y) lags a ramp of slope v by v step (1 - a) / a, and (1 - a) / a is tau
// / step: the delay is tau for any step.
double OneEuroFilter::filtered(double value, double time_s)
{
  const double step_s = time_s - time_s_;
  if (has_last_ && step_s == 0.0) return value_;
  if (!has_last_ || step_s < 0.0) {
    speed_ = 0.0;
    value_ = value;
  } else {
    speed_ += share(options_.speed_cutoff_hz, step_s) * ((value - raw_) / step_s - speed_);
    value_ += share(cutoff_hz(options_, std::abs(speed_)), step_s) * (value - value_);
  }
  has_last_ = true;
  time_s_ = time_s;
  raw_ = value;
  return value_;
}

LegAngles OneEuroAngles::filtered(const LegAngles& angles, double time_s)
{
  return {flexion_.filtered(angles.flexion_rad, time_s), varus_.filtered(angles.varus_rad, time_s),
          theta_.filtered(angles.theta_rad, time_s)};
}

void OneEuroAngles::start_over()
{
  flexion_.start_over();
  varus_.start_over();
  theta_.start_over();
}

Pose OneEuroPose::filtered(const Pose& X, double time_s)
{
  const double step_s = time_s - time_s_;
  if (has_last_ && step_s == 0.0) return value_;
  if (!has_last_ || step_s < 0.0) {
    speed_mm_s_.setZero();
    speed_rad_s_.setZero();
    value_ = X;
  } else {
    const Eigen::Vector3d way_mm = X.translation() - raw_.translation();
    speed_mm_s_ += share(options_.position.speed_cutoff_hz, step_s) * (way_mm / step_s - speed_mm_s_);
    const Eigen::Vector3d turn_rad = turn_of(X.linear() * raw_.linear().transpose());
    speed_rad_s_ += share(options_.rotation.speed_cutoff_hz, step_s) * (turn_rad / step_s - speed_rad_s_);

    const double s_position = share(cutoff_hz(options_.position, speed_mm_s_.norm()), step_s);
    value_.translation() += s_position * (X.translation() - value_.translation());
    const double s_rotation = share(cutoff_hz(options_.rotation, speed_rad_s_.norm()), step_s);
    const Eigen::Matrix3d R_value = value_.linear();
    const Eigen::Vector3d left_rad = turn_of(X.linear() * R_value.transpose());
    // Normalised, so that rounding does not accumulate over hours.
    const Eigen::Quaterniond turned(rotation_of(s_rotation * left_rad) * R_value);
    value_.linear() = turned.normalized().toRotationMatrix();
  }
  has_last_ = true;
  time_s_ = time_s;
  raw_ = X;
  return value_;
}

}  // namespace vrda::tracking
