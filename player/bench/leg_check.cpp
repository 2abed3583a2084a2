#include "bench/leg_check.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {
namespace {

constexpr double range_slack_rad = rad_from_deg(1.0);
// A knee overextends by up to 15 degrees, and models end at 90 where knees bend to 160.
constexpr double most_before_rad = rad_from_deg(20.0), most_after_rad = rad_from_deg(75.0);
constexpr double most_beside_rad = rad_from_deg(30.0), largest_rotation_rad = rad_from_deg(60.0);

BeyondRange beyond(double measured_rad, double first_rad, double last_rad)
{
  const double nearest_rad = std::clamp(measured_rad, first_rad, last_rad);
  // A motion with one varus, or its own, has no range of it.
  const bool is_range = first_rad < last_rad;
  return {measured_rad, nearest_rad, is_range && std::abs(measured_rad - nearest_rad) > range_slack_rad};
}

bool is_plausible(const BeyondRange& flexion, const BeyondRange& varus, double rotation_rad)
{
  const double after_rad = flexion.measured_rad - flexion.nearest_rad;
  const double beside_rad = varus.measured_rad - varus.nearest_rad;
  return after_rad >= -most_before_rad && after_rad <= most_after_rad &&
         std::abs(beside_rad) <= most_beside_rad && std::abs(rotation_rad) <= largest_rotation_rad;
}

std::string beyond_text(const char* angle, const BeyondRange& at)
{
  const auto degrees = [](double rad) { return show::rounded_text(std::round(deg_from_rad(rad)), 0); };
  return std::string(angle) + ' ' + degrees(at.measured_rad) + ", model " +
         (at.measured_rad > at.nearest_rad ? "ends" : "begins") + " at " + degrees(at.nearest_rad);
}

}  // namespace

LegCheck check_leg(const store::Motion& motion, const bench::LegAngles& measured,
                   const bench::LegAngles& exchanged)
{
  const auto flexion_of = [&motion](const bench::LegAngles& angles) {
    return beyond(angles.flexion_rad, motion.first_flexion_rad(), motion.last_flexion_rad());
  };
  const auto varus_of = [&motion](const bench::LegAngles& angles) {
    return beyond(angles.varus_rad, motion.first_varus_rad(), motion.last_varus_rad());
  };
  LegCheck check{flexion_of(measured), varus_of(measured), false, false, measured.theta_rad};
  check.is_implausible = !is_plausible(check.flexion, check.varus, measured.theta_rad);
  const BeyondRange other = flexion_of(exchanged);
  check.are_bodies_exchanged = check.is_implausible && !other.is_beyond &&
                               is_plausible(other, varus_of(exchanged), exchanged.theta_rad);
  return check;
}

std::string leg_check_text(const LegCheck& check)
{
  if (!check.is_wrong()) return {};
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  // The cause first: narrow windows cut the end.
  if (check.are_bodies_exchanged) {
    add("femur and tibia bodies probably exchanged");
  } else if (check.is_implausible) {
    add("implausible angles: check bodies and calibration");
  }
  if (check.flexion.is_beyond) add(beyond_text("flexion", check.flexion));
  if (check.varus.is_beyond) add(beyond_text("varus", check.varus));
  if (std::abs(check.rotation_rad) > largest_rotation_rad)
    add("rotation " + show::rounded_text(std::round(deg_from_rad(check.rotation_rad)), 0));
  return text;
}

}  // namespace vrda::bench
