#include "simulation/script.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda {
namespace {

struct Range {
  double least = 0.0, most = 0.0;
};

class Checker {
 public:
  explicit Checker(const std::string& file) : file_(file) {}

  void require(bool is_right, const std::string& field, const std::string& found,
               const std::string& wanted) const
  {
    if (!is_right) throw InputError({file_, field, found, wanted});
  }
  void within(double value, const Range& range, const std::string& field) const
  {
    require(value >= range.least && value <= range.most, field, shortest(value),
            shortest(range.least) + " to " + shortest(range.most));
  }

  /// Of keys by time; `is_same(first, last)` says whether a loop closes.
  template <typename Keys, typename IsSame>
  void path(const Keys& keys, bool is_looped, const std::string& field, IsSame is_same) const
  {
    require(!keys.empty(), field, "no keys", "one or more");
    for (std::size_t i = 1; i < keys.size(); ++i) {
      require(keys[i].time_s > keys[i - 1].time_s, field + " key " + std::to_string(i + 1),
              "time " + shortest(keys[i].time_s), "a time after " + shortest(keys[i - 1].time_s));
    }
    require(!is_looped || is_same(keys.front(), keys.back()), field, "a loop whose ends differ",
            "a last key with the values of the first");
  }

 private:
  std::string file_;
};

constexpr double longest_s = 1e6;

void require_paths(const SimulationScript& script, const Checker& checker)
{
  checker.path(script.leg, script.is_looped, "leg", [](const LegKey& a, const LegKey& b) {
    return a.flexion_deg == b.flexion_deg && a.varus_deg == b.varus_deg;
  });
  checker.path(script.stage, script.is_looped, "stage",
               [](const StageKey& a, const StageKey& b) { return a.position_mm == b.position_mm; });
  checker.path(script.potentiometer, script.is_looped, "potentiometer",
               [](const PotentiometerKey& a, const PotentiometerKey& b) { return a.count == b.count; });
  for (const LegKey& key : script.leg) {
    checker.within(key.time_s, {0.0, longest_s}, "leg time_s");
    checker.within(key.flexion_deg, {-180.0, 180.0}, "leg flexion_deg");
    checker.within(key.varus_deg, {-80.0, 80.0}, "leg varus_deg");
  }
  for (const StageKey& key : script.stage) {
    checker.within(key.time_s, {0.0, longest_s}, "stage time_s");
    checker.within(key.position_mm, {-1000.0, 1000.0}, "stage position_mm");
  }
  for (const PotentiometerKey& key : script.potentiometer) {
    checker.within(key.time_s, {0.0, longest_s}, "potentiometer time_s");
    checker.within(key.count, {0.0, 1023.0}, "potentiometer count");
  }
}

void require_tools(const SimulationScript& script, const Checker& checker)
{
  std::vector<std::string> names = tool_names(script);
  std::sort(names.begin(), names.end());
  checker.require(!std::binary_search(names.begin(), names.end(), ""), "tool", "a name that is empty",
                  "a name");
  const auto twice = std::adjacent_find(names.begin(), names.end());
  checker.require(twice == names.end(), "tool", twice == names.end() ? "" : *twice + " twice",
                  "names that differ");
  for (const Occlusion& occlusion : script.occlusions) {
    checker.require(std::binary_search(names.begin(), names.end(), occlusion.tool), "occlusion tool",
                    occlusion.tool, "a tool");
    checker.within(occlusion.from_s, {0.0, longest_s}, "occlusion from_s");
    checker.within(occlusion.to_s, {occlusion.from_s, longest_s}, "occlusion to_s");
    checker.require(occlusion.every_s == 0.0 || occlusion.every_s >= occlusion.to_s - occlusion.from_s,
                    "occlusion every_s", shortest(occlusion.every_s), "0, or no shorter than it lasts");
  }
}

void require_clock(const DeviceClock& clock, const Checker& checker)
{
  checker.within(clock.offset_s, {1.0, 4e9}, "clock offset_s");
  checker.within(clock.drift_ppm, {-1e5, 1e5}, "clock drift_ppm");
  for (std::size_t i = 0; i < clock.steps.size(); ++i) {
    checker.within(clock.steps[i].at_s, {i == 0 ? 0.0 : clock.steps[i - 1].at_s, longest_s},
                   "clock step at_s");
    checker.within(clock.steps[i].by_ms, {-1e9, 1e9}, "clock step by_ms");
  }
}

}  // namespace

Pose default_X_tracker_femur()
{
  Pose X = Pose::Identity();
  // Anterior to the viewer, proximal up, the subject's right to the viewer's left.
  X.linear() << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  X.translation() << 0, 0, -1500;
  return X;
}

std::vector<std::string> tool_names(const SimulationScript& script)
{
  std::vector<std::string> names;
  const auto add = [&](const SimulatedBody& body) {
    names.push_back(body.tool);
    for (std::size_t k = 0; k < body.markers_mm.size(); ++k) {
      names.push_back(body.tool + "-" + std::to_string(k + 1));
    }
  };
  add(script.femur);
  add(script.tibia);
  if (script.head) add(*script.head);
  return names;
}

void require_usable(const SimulationScript& script, const std::string& file)
{
  const Checker checker(file);
  checker.within(script.rate_hz, {0.1, 10000.0}, "rate_hz");
  // Beyond a period frames would overtake each other.
  checker.within(script.jitter_ms, {0.0, 1000.0 / script.rate_hz}, "jitter_ms");
  checker.within(script.drop_rate, {0.0, 1.0}, "drop_rate");
  checker.within(script.noise_mm, {0.0, 1000.0}, "noise_mm");
  checker.within(script.noise_deg, {0.0, 25.0}, "noise_deg");
  checker.within(script.potentiometer_noise_counts, {0.0, 1023.0}, "potentiometer_noise_counts");
  checker.within(script.sway_mm, {0.0, 1000.0}, "sway_mm");
  checker.within(script.sway_s, {0.1, longest_s}, "sway_s");
  checker.within(script.firing_interval_ms, {0.0, 1000.0}, "firing_interval_ms");
  require_paths(script, checker);
  require_tools(script, checker);
  require_clock(script.clock, checker);
}

}  // namespace vrda
