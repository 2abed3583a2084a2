#include "bench/one_euro.hpp"

#include "core/units.hpp"

namespace vrda::bench {
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

}  // namespace vrda::bench
