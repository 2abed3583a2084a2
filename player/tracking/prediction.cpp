#include "tracking/prediction.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace vrda {
namespace {

/// Makes room at the end for a sample of `time_s`: leaves out what is older than the window, and the oldest
/// of a full one. Returns how many remain.
template <typename Samples>
std::size_t make_room(Samples& samples, std::size_t n, double time_s, double window_s)
{
  if (n > 0 && time_s <= samples[n - 1].time_s) return 0;
  std::size_t first = n == most_window_samples ? 1 : 0;
  while (first < n && samples[first].time_s < time_s - window_s) ++first;
  std::move(samples.begin() + static_cast<std::ptrdiff_t>(first),
            samples.begin() + static_cast<std::ptrdiff_t>(n), samples.begin());
  return n - first;
}

/// Slope of the straight line that fits values at times best.
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
  /// Of two values or more.
  Vector a_second() const { return product_ / time_sq_s2_; }

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

void PlacePredictor::add(const TimedPose& sample)
{
  n_ = make_room(samples_, n_, sample.time_s, options_.window_s);
  samples_[n_++] = sample;
}

Screw PlacePredictor::velocity() const
{
  check(has_sample(), "a predictor is asked after its first sample");
  const TimedPose& last = samples_[n_ - 1];
  if (n_ < 2 || last.time_s - samples_[0].time_s < options_.shortest_span_s) return {};
  Slope<Vector6> slope;
  for (std::size_t i = 0; i < n_; ++i) {
    const Screw screw = screw_of(last.X.inverse() * samples_[i].X);
    Vector6 numbers;
    numbers << screw.turn_rad, screw.shift_mm;
    slope.add(samples_[i].time_s - last.time_s, numbers);
  }
  const Vector6 a_second = slope.a_second();
  return {a_second.head<3>(), a_second.tail<3>()};
}

Pose PlacePredictor::at(double time_s) const
{
  const Screw a_second = velocity();
  const TimedPose& last = samples_[n_ - 1];
  const Pose X_last_then =
      pose_of(scaled(a_second, std::clamp(time_s - last.time_s, 0.0, options_.longest_s)));
  return last.X * X_last_then;
}

void AnglesPredictor::add(const TimedAngles& sample)
{
  n_ = make_room(samples_, n_, sample.time_s, options_.window_s);
  samples_[n_++] = sample;
}

LegAngles AnglesPredictor::velocity() const
{
  check(has_sample(), "a predictor is asked after its first sample");
  if (n_ < 2 || samples_[n_ - 1].time_s - samples_[0].time_s < options_.shortest_span_s) return {};
  Slope<Eigen::Vector3d> slope;
  for (std::size_t i = 0; i < n_; ++i) {
    slope.add(samples_[i].time_s - samples_[n_ - 1].time_s, vector_of(samples_[i].angles));
  }
  return angles_of(slope.a_second());
}

LegAngles AnglesPredictor::at(double time_s) const
{
  const Eigen::Vector3d a_second = vector_of(velocity());
  const TimedAngles& last = samples_[n_ - 1];
  const double ahead_s = std::clamp(time_s - last.time_s, 0.0, options_.longest_s);
  return angles_of(vector_of(last.angles) + ahead_s * a_second);
}

}  // namespace vrda
