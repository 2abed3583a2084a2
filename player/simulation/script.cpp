#include "simulation/script.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/text.hpp"

namespace vrda::simulation {
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
  checker.path(script.stage, script.is_looped, "stage",
               [](const StageKey& a, const StageKey& b) { return a.position_mm == b.position_mm; });
  checker.path(script.potentiometer, script.is_looped, "potentiometer",
               [](const PotentiometerKey& a, const PotentiometerKey& b) { return a.count == b.count; });
}

void require_tools(const SimulationScript& script, const Checker& checker)
{
  std::vector<std::string> names = tool_names(script);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  checker.require(twice == names.end(), "tool", twice == names.end() ? "" : *twice + " twice",
                  "unique names");
  for (const Occlusion& occlusion : script.occlusions) {
    checker.require(std::binary_search(names.begin(), names.end(), occlusion.tool), "occlusion tool",
                    occlusion.tool, "a tool");
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
  // With a longer jitter frames could overtake each other.
  const double period_ms = 1000.0 / script.rate_hz;
  checker.require(script.jitter_ms <= period_ms, "jitter_ms", shortest_decimal(script.jitter_ms),
                  "at most the frame period, " + shortest_decimal(period_ms));
  require_paths(script, checker);
  require_tools(script, checker);
  require_clock(script.clock, checker);
}

}  // namespace vrda::simulation
