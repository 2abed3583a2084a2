#include "tables/flexion_motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "model/side.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::tables {
namespace {

void require_varus(const store::MotionModel& model, const store::Motion& motion, const std::string& file,
                   const FlexionPlan& plan)
{
  if (plan.varus == VarusRule::zero && !model.zero_varus) {
    throw InputError(
        {file, "--varus", "zero without a zero-varus table", "spine or a number; or run vrda reduce first"});
  }
  if (plan.varus != VarusRule::given) return;
  if (motion.is_varus_free()) {
    throw InputError({file, "--varus", shortest_decimal(plan.varus_deg),
                      model.varus_deg.size() > 1 ? "spine, or another --set: this set has its own varus"
                                                 : "spine: the job left varus free"});
  }
  const double varus_rad = rad_from_deg(plan.varus_deg);
  if (varus_rad >= motion.first_varus_rad() && varus_rad <= motion.last_varus_rad()) return;
  throw InputError(
      {file, "--varus", shortest_decimal(plan.varus_deg) + " degrees",
       shortest_decimal(model.varus_deg.front()) + " to " + shortest_decimal(model.varus_deg.back())});
}

bool has_zero_varus(const store::ZeroVarus& table, std::size_t flexion)
{
  return table.source[flexion] != static_cast<std::int8_t>(store::ZeroVarusSource::none);
}

/// Linear interpolation between two flexions with a zero-varus pose.
std::optional<double> zero_varus_deg(const store::MotionModel& model, double flexion_deg)
{
  const store::ZeroVarus& table = *model.zero_varus;
  const std::vector<double>& grid_deg = model.flexion_deg;
  const auto after = std::lower_bound(grid_deg.begin(), grid_deg.end(), flexion_deg);
  if (after == grid_deg.end()) return {};
  const auto i = static_cast<std::size_t>(after - grid_deg.begin());
  if (!has_zero_varus(table, i)) return {};
  if (grid_deg[i] == flexion_deg) return table.varus_deg[i];
  if (i == 0 || !has_zero_varus(table, i - 1)) return {};
  const double s = (flexion_deg - grid_deg[i - 1]) / (grid_deg[i] - grid_deg[i - 1]);
  return table.varus_deg[i - 1] + s * (table.varus_deg[i] - table.varus_deg[i - 1]);
}

std::optional<double> varus_deg_at(const store::MotionModel& model, const store::Motion& motion,
                                   const FlexionPlan& plan, double flexion_deg)
{
  switch (plan.varus) {
    case VarusRule::given:
      return plan.varus_deg;
    case VarusRule::spine:
      return deg_from_rad(motion.balanced_varus_rad(rad_from_deg(flexion_deg)));
    case VarusRule::zero:
      return zero_varus_deg(model, flexion_deg);
  }
  throw InternalError("an unknown varus rule");
}

void add_frame(FlexionMotion& result, const store::Motion& motion, double flexion_deg,
               std::optional<double> varus_deg)
{
  const double flexion_rad = rad_from_deg(flexion_deg);
  if (flexion_rad < motion.first_flexion_rad() || flexion_rad > motion.last_flexion_rad()) {
    result.omitted.push_back({flexion_deg, nan, "beyond the measured range"});
    return;
  }
  if (!varus_deg) {
    result.omitted.push_back({flexion_deg, nan, "no zero-varus pose"});
    return;
  }
  FlexionFrame frame{flexion_deg, motion.at({flexion_rad, rad_from_deg(*varus_deg)}), {}};
  if (frame.pose.status != store::PoseStatus::solved) {
    result.omitted.push_back({flexion_deg, nan, store::name_of(frame.pose.status)});
    return;
  }
  result.frames.push_back(frame);
}

void add_frames(FlexionMotion& result, const store::MotionModel& model, const store::Motion& motion)
{
  result.key_name = motion.key_name();
  for (std::size_t i = 0; i < motion.keys().size(); ++i) {
    FlexionFrame frame{model.flexion_deg[i], motion.at_frame(motion.keys()[i]), {}};
    if (frame.pose.status != store::PoseStatus::solved) {
      result.omitted.push_back({frame.flexion_deg, frame.pose.key, "no pose"});
      continue;
    }
    result.frames.push_back(frame);
  }
}

void make_continuous(FlexionMotion& motion)
{
  ContinuousCoordinates along(motion.side, motion.rotation_centre_mm);
  for (FlexionFrame& frame : motion.frames) frame.clinical = along.next(frame.pose.X_reference_moving);
  motion.n_locked = along.n_locked();
  // The attitudes of a sequence have any number of turns.
  for (std::size_t k = 1; k < motion.frames.size() && !motion.key_name.empty(); ++k) {
    const store::JointPose& before = motion.frames[k - 1].pose;
    FlexionFrame& frame = motion.frames[k];
    Attitude& attitude = frame.pose.attitude;
    attitude.flexion_rad = nearest_turn(attitude.flexion_rad, before.attitude.flexion_rad);
    frame.pose.theta_rad = nearest_turn(frame.pose.theta_rad, before.theta_rad);
    constexpr double rounding_deg = 1e-6;
    const double flexion_deg = deg_from_rad(attitude.flexion_rad);
    if (std::abs(flexion_deg - frame.flexion_deg) > rounding_deg) frame.flexion_deg = flexion_deg;
  }
}

}  // namespace

const char* name_of(VarusRule rule)
{
  switch (rule) {
    case VarusRule::given:
      return "given";
    case VarusRule::spine:
      return "spine";
    case VarusRule::zero:
      return "zero";
  }
  throw InternalError("an unknown varus rule");
}

VarusRule default_varus(const store::MotionModel& model, const std::string& set)
{
  const bool is_raw = (set.empty() ? store::default_motion(model).set : set) == "raw";
  return model.zero_varus && !is_raw ? VarusRule::zero : VarusRule::spine;
}

FlexionMotion flexion_motion(const store::MotionModel& model, const std::string& file,
                             const FlexionPlan& plan)
{
  FlexionMotion result;
  result.title = model.title;
  result.set = store::chosen_set(model, file, plan.set);
  if (plan.set.empty()) result.reason = store::default_motion(model).reason;
  result.side = side_named(model.side);
  result.rotation_centre_mm = model.rotation_centre_mm;
  const store::Motion motion(model, result.set);
  if (motion.is_sequence()) {
    if (!plan.flexion_deg.empty() || plan.varus != VarusRule::spine)
      store::require_grid(model, file, plan.flexion_deg.empty() ? "--varus" : "--flexion");
    add_frames(result, model, motion);
  } else {
    require_varus(model, motion, file, plan);
    for (const double flexion_deg : plan.flexion_deg.empty() ? model.flexion_deg : plan.flexion_deg)
      add_frame(result, motion, flexion_deg, varus_deg_at(model, motion, plan, flexion_deg));
  }
  make_continuous(result);
  if (result.frames.empty()) {
    throw InputError({file, result.set, "no attitude with a pose", "at least one to export"});
  }
  return result;
}

std::string set_text(const FlexionMotion& motion)
{
  return motion.set + (motion.reason.empty() ? "" : ": " + motion.reason);
}

double abscissa(const FlexionMotion& motion, const FlexionFrame& frame)
{
  return motion.key_name.empty() ? frame.flexion_deg : frame.pose.key;
}

double time_s(const FlexionMotion& motion, const FlexionFrame& frame, double rate)
{
  const double since_first = abscissa(motion, frame) - abscissa(motion, motion.frames.front());
  return motion.key_name == "time_s" ? since_first : since_first / rate;
}

}  // namespace vrda::tables
