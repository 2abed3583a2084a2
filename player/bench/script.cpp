#include "bench/script.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda::bench {
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
  for (std::size_t i = 1; i < n; ++i)
    check(points_[i].time_s > points_[i - 1].time_s, "the keys of a path must ascend in time");
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

namespace {

class Checker {
 public:
  explicit Checker(const std::string& file) : file_(file) {}

  void require(bool is_right, const std::string& field, const std::string& found,
               const std::string& wanted) const
  {
    if (!is_right) throw InputError({file_, field, found, wanted});
  }
  /// Checks that keys ascend in time; `is_same(first, last)` returns whether a loop closes.
  template <typename Keys, typename IsSame>
  void path(const Keys& keys, bool is_looped, const std::string& field, IsSame is_same) const
  {
    for (std::size_t i = 1; i < keys.size(); ++i) {
      require(keys[i].time_s > keys[i - 1].time_s, field + " key " + std::to_string(i + 1),
              "time " + shortest_decimal(keys[i].time_s),
              "a time after " + shortest_decimal(keys[i - 1].time_s));
    }
    require(!is_looped || is_same(keys.front(), keys.back()), field,
            "different first and last values of a loop", "a last key with the values of the first");
  }

 private:
  std::string file_;
};

void require_paths(const SimulationScript& script, const Checker& checker)
{
  checker.path(script.leg, script.is_looped, "leg", [](const LegKey& a, const LegKey& b) {
    return a.flexion_deg == b.flexion_deg && a.varus_deg == b.varus_deg;
  });
  const auto is_same = [](const PathPoint& a, const PathPoint& b) { return a.value == b.value; };
  checker.path(script.stage, script.is_looped, "stage", is_same);
  checker.path(script.potentiometer, script.is_looped, "potentiometer", is_same);
}

void require_tools(const SimulationScript& script, const Checker& checker)
{
  const std::vector<std::string> tools = tool_names(script);
  std::vector<std::string> names = tools;
  std::ranges::sort(names);
  const auto twice = std::adjacent_find(names.begin(), names.end());
  checker.require(twice == names.end(), "tool", twice == names.end() ? "" : *twice + " twice",
                  "unique names");
  for (const Occlusion& occlusion : script.occlusions) {
    checker.require(std::ranges::find(tools, occlusion.tool) != tools.end(), "occlusion tool",
                    "\"" + occlusion.tool + "\"", join_alternatives(tools));
    checker.require(occlusion.to_s >= occlusion.from_s, "occlusion to_s", shortest_decimal(occlusion.to_s),
                    "at least from_s = " + shortest_decimal(occlusion.from_s));
    checker.require(occlusion.every_s == 0.0 || occlusion.every_s >= occlusion.to_s - occlusion.from_s,
                    "occlusion every_s", shortest_decimal(occlusion.every_s), "0, or at least to_s - from_s");
  }
}

void require_clock(const DeviceClock& clock, const Checker& checker)
{
  for (std::size_t i = 1; i < clock.steps.size(); ++i) {
    checker.require(clock.steps[i].at_s >= clock.steps[i - 1].at_s, "clock step at_s",
                    shortest_decimal(clock.steps[i].at_s),
                    "at least the previous step's time, " + shortest_decimal(clock.steps[i - 1].at_s));
  }
}

}  // namespace

Pose default_X_tracker_femur()
{
  Pose X = Pose::Identity();
  // Anterior towards the viewer, proximal up, the subject's right to the viewer's left.
  X.linear() << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  X.translation() << 0, 0, -1500;
  return X;
}

std::vector<std::string> tool_names(const SimulationScript& script)
{
  std::vector<std::string> names;
  const auto add = [&](const SimulatedBody& body) {
    names.push_back(body.tool);
    for (std::size_t k = 0; k < body.markers_mm.size(); ++k)
      names.push_back(body.tool + "-" + std::to_string(k + 1));
  };
  add(script.femur);
  add(script.tibia);
  if (script.head) add(*script.head);
  return names;
}

void require_usable(const SimulationScript& script, const std::string& file)
{
  const Checker checker(file);
  // With a longer jitter frames could overtake each other.
  const double period_ms = 1000.0 / script.rate_hz;
  checker.require(script.jitter_ms <= period_ms, "jitter_ms", shortest_decimal(script.jitter_ms),
                  "at most the frame period, " + shortest_decimal(period_ms));
  require_paths(script, checker);
  require_tools(script, checker);
  require_clock(script.clock, checker);
}

}  // namespace vrda::bench
