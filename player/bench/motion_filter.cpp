#include "bench/motion_filter.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
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

namespace {

/// Slope of the least-squares line through values at times.
template <typename Vector>
class Slope {
 public:
  void add(double time_s, const Vector& value)
  {
    n_ += 1.0;
    const double from_mean_s = time_s - mean_time_s_;
    mean_time_s_ += from_mean_s / n_;
    const Vector from_mean = value - mean_;
    mean_ += from_mean / n_;
    time_sq_s2_ += from_mean_s * (time_s - mean_time_s_);
    product_ += from_mean_s * (value - mean_);
  }
  /// Requires two values or more.
  Vector per_second() const { return product_ / time_sq_s2_; }

 private:
  double n_ = 0.0, mean_time_s_ = 0.0, time_sq_s2_ = 0.0;
  Vector mean_ = Vector::Zero(), product_ = Vector::Zero();
};

using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Vector3d vector_of(const LegAngles& angles)
{
  return {angles.flexion_rad, angles.varus_rad, angles.theta_rad};
}

LegAngles angles_of(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

}  // namespace

template <typename Sample>
void SampleWindow<Sample>::add(const Sample& sample)
{
  if (n_ > 0 && sample.time_s <= last().time_s) n_ = 0;
  std::size_t first = n_ == max_window_samples ? 1 : 0;
  while (first < n_ && samples_[first].time_s < sample.time_s - options_.window_s) ++first;
  std::move(samples_.begin() + static_cast<std::ptrdiff_t>(first),
            samples_.begin() + static_cast<std::ptrdiff_t>(n_), samples_.begin());
  n_ -= first;
  samples_[n_++] = sample;
}

template <typename Sample>
bool SampleWindow<Sample>::has_velocity() const
{
  check(has_sample(), "a predictor needs a sample");
  return n_ > 1 && last().time_s - samples_[0].time_s >= options_.shortest_span_s;
}

template class SampleWindow<TimedPose>;
template class SampleWindow<TimedAngles>;

Screw PosePredictor::velocity() const
{
  if (!has_velocity()) return {};
  Slope<Vector6> slope;
  for (std::size_t i = 0; i < n_; ++i) {
    const Screw screw = screw_of(last().X.inverse() * samples_[i].X);
    Vector6 numbers;
    numbers << screw.turn_rad, screw.shift_mm;
    slope.add(samples_[i].time_s - last().time_s, numbers);
  }
  const Vector6 per_second = slope.per_second();
  return {per_second.head<3>(), per_second.tail<3>()};
}

Pose PosePredictor::at(double time_s) const
{
  const Screw per_second = velocity();
  return last().X * pose_of(scaled(per_second, std::clamp(time_s - last().time_s, 0.0, options_.longest_s)));
}

LegAngles AnglesPredictor::velocity() const
{
  if (!has_velocity()) return {};
  Slope<Eigen::Vector3d> slope;
  for (std::size_t i = 0; i < n_; ++i)
    slope.add(samples_[i].time_s - last().time_s, vector_of(samples_[i].angles));
  return angles_of(slope.per_second());
}

LegAngles AnglesPredictor::at(double time_s) const
{
  const Eigen::Vector3d per_second = vector_of(velocity());
  const double ahead_s = std::clamp(time_s - last().time_s, 0.0, options_.longest_s);
  return angles_of(vector_of(last().angles) + ahead_s * per_second);
}

namespace {

struct Errors {
  std::vector<double> held, predicted;
  PredictionError summary() const { return {summary_of(held), summary_of(predicted)}; }
};

void add_errors(Errors& shift_mm, Errors& turn_rad, const Pose& X_then, const std::array<Pose, 2>& estimates)
{
  const Pose X_held = X_then.inverse() * estimates[0];
  const Pose X_predicted = X_then.inverse() * estimates[1];
  shift_mm.held.push_back(X_held.translation().norm());
  shift_mm.predicted.push_back(X_predicted.translation().norm());
  turn_rad.held.push_back(turn_of(X_held.linear()).norm());
  turn_rad.predicted.push_back(turn_of(X_predicted.linear()).norm());
}

}  // namespace

ErrorSummary summary_of(std::vector<double> errors)
{
  ErrorSummary summary;
  summary.n = errors.size();
  if (errors.empty()) return summary;
  double sum_sq = 0.0;
  for (const double error : errors) sum_sq += error * error;
  summary.rms = std::sqrt(sum_sq / static_cast<double>(errors.size()));
  std::ranges::sort(errors);
  const std::size_t n_within = (95 * errors.size() + 99) / 100;
  summary.percentile_95 = errors[n_within - 1];
  return summary;
}

PosePredictionError prediction_error(std::span<const TimedPose> series, double horizon_s,
                                     const PredictionOptions& options)
{
  PosePredictor predictor(options);
  Errors shift_mm, turn_rad;
  std::size_t j = 0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    check(i == 0 || series[i].time_s > series[i - 1].time_s, "the times of a series must ascend");
    const double time_s = series[i].time_s + horizon_s;
    while (j + 1 < series.size() && series[j + 1].time_s < time_s) ++j;
    if (j + 1 == series.size()) break;
    predictor.add(series[i]);
    const double s = (time_s - series[j].time_s) / (series[j + 1].time_s - series[j].time_s);
    const Pose X_then = between(series[j].X, series[j + 1].X, s);
    add_errors(shift_mm, turn_rad, X_then, {series[i].X, predictor.at(time_s)});
  }
  return {shift_mm.summary(), turn_rad.summary()};
}

}  // namespace vrda::bench
