#include "simulation/key_path.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace vrda::simulation {
namespace {

double chord(const PathPoint& from, const PathPoint& to)
{
  return (to.value - from.value) / (to.time_s - from.time_s);
}

/// Weighted harmonic mean of the chords on either side, which last `before_s` and `after_s`.
double slope_between(double before, double before_s, double after, double after_s)
{
  if (before * after <= 0.0) return 0.0;
  const double weight_before = before_s + 2.0 * after_s, weight_after = 2.0 * before_s + after_s;
  return (weight_before + weight_after) / (weight_before / before + weight_after / after);
}

}  // namespace

KeyPath::KeyPath(std::vector<PathPoint> points, bool is_looped)
    : points_(std::move(points)), slopes_(points_.size(), 0.0), is_looped_(is_looped && points_.size() > 1)
{
  check(!points_.empty(), "a path needs at least one key");
  const std::size_t n = points_.size();
  for (std::size_t i = 1; i < n; ++i) {
    check(points_[i].time_s > points_[i - 1].time_s, "the keys of a path must ascend in time");
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    slopes_[i] = slope_between(chord(points_[i - 1], points_[i]), points_[i].time_s - points_[i - 1].time_s,
                               chord(points_[i], points_[i + 1]), points_[i + 1].time_s - points_[i].time_s);
  }
  if (!is_looped_) return;
  check(points_.front().value == points_.back().value, "a looped path must end at its first value");
  slopes_.front() =
      slope_between(chord(points_[n - 2], points_[n - 1]), points_[n - 1].time_s - points_[n - 2].time_s,
                    chord(points_[0], points_[1]), points_[1].time_s - points_[0].time_s);
  slopes_.back() = slopes_.front();
}

double KeyPath::at(double time_s) const
{
  const double first_s = points_.front().time_s, last_s = points_.back().time_s;
  double t = time_s;
  if (is_looped_) {
    const double period_s = last_s - first_s;
    t = time_s - period_s * std::floor((time_s - first_s) / period_s);
  }
  if (t <= first_s) return points_.front().value;
  if (t >= last_s) return points_.back().value;
  const auto after =
      std::upper_bound(points_.begin(), points_.end(), t,
                       [](double wanted_s, const PathPoint& p) { return wanted_s < p.time_s; });
  const auto i = static_cast<std::size_t>(after - points_.begin()) - 1;
  const PathPoint &from = points_[i], &to = points_[i + 1];
  const double length_s = to.time_s - from.time_s;
  const double s = (t - from.time_s) / length_s, left = 1.0 - s;
  // Cubic Hermite polynomial, written relative to either end.
  return left * left * ((1.0 + 2.0 * s) * from.value + s * length_s * slopes_[i]) +
         s * s * ((1.0 + 2.0 * left) * to.value - left * length_s * slopes_[i + 1]);
}

}  // namespace vrda::simulation
