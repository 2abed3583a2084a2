#include "view/arguments.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <ostream>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "store/poses.hpp"
#include "view/camera.hpp"

namespace vrda::view {
namespace {

constexpr double most_angles = 10000.0;  // a longer series would take hours
constexpr double least_step_deg = 1e-3;
constexpr double largest_angle_deg = 360.0;  // larger values are typing errors
constexpr int smallest_side = 16,
              largest_side = 4096;  // pixels; the largest takes half a gigabyte at four samples

template <typename Number>
std::optional<Number> whole_number(const std::string& text)
{
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> angle_of(const std::string& text)
{
  const std::optional<double> value = whole_number<double>(text);
  if (!value || !(std::abs(*value) <= largest_angle_deg)) return std::nullopt;
  return value;
}

/// Number of decimals needed for the angle at a resolution of a thousandth of a degree.
int decimals_of(double angle_deg)
{
  double scale = 1.0;
  for (int decimals = 0; decimals < 3; ++decimals, scale *= 10.0) {
    if (std::abs(angle_deg * scale - std::round(angle_deg * scale)) < 1e-3 * scale * 0.5) return decimals;
  }
  return 3;
}

constexpr double same_angle_rad = rad_from_deg(1e-6);

/// True if the clamping exceeds the rounding of degree conversion.
bool is_beyond(double wanted_rad, double used_rad)
{
  return std::abs(wanted_rad - used_rad) > same_angle_rad;
}

}  // namespace

std::vector<std::string> split(const std::string& text, char separator)
{
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

AngleRange parsed_angles(const std::string& option, const std::string& text)
{
  const std::string form = "A:B:STEP or A, in degrees, such as 0:90:15";
  const std::vector<std::string> parts = split(text, ':');
  std::vector<double> values;
  for (const std::string& part : parts) {
    const std::optional<double> value = angle_of(part);
    if (!value) throw InputError({option, "", "\"" + text + "\"", form});
    values.push_back(*value);
  }
  if (values.size() == 1) return {values[0], values[0], 1.0};
  if (values.size() != 3) throw InputError({option, "", "\"" + text + "\"", form});
  const AngleRange range{values[0], values[1], values[2]};
  // Labels have three decimals.
  if (range.step_deg < least_step_deg)
    throw InputError({option, "STEP", parts[2], "a step of 0.001 or more"});
  if (range.last_deg < range.first_deg) {
    throw InputError({option, "", "\"" + text + "\"", "A at most B"});
  }
  if ((range.last_deg - range.first_deg) / range.step_deg >= most_angles) {
    throw InputError({option, "STEP", parts[2], "at most 10000 angles"});
  }
  return range;
}

void require_angle(const std::string& option, double angle_deg)
{
  if (!(std::abs(angle_deg) <= largest_angle_deg))
    throw InputError({option, "", shortest_decimal(angle_deg), "-360 to 360 degrees"});
}

void refuse_option(const char* option, const std::string& found, const std::string& wanted)
{
  throw InputError({option, "", found, wanted});
}

std::vector<double> angles_deg(const AngleRange& range)
{
  const double steps = (range.last_deg - range.first_deg) / range.step_deg;
  const auto n = static_cast<int>(std::floor(steps + 1e-6));
  std::vector<double> angles;
  for (int i = 0; i <= n; ++i)
    angles.push_back(std::min(range.first_deg + i * range.step_deg, range.last_deg));
  return angles;
}

PictureSize parsed_size(const std::string& text)
{
  const std::vector<std::string> parts = split(text, 'x');
  std::vector<int> sides;
  for (const std::string& part : parts) {
    const int side = whole_number<int>(part).value_or(0);
    if (side >= smallest_side && side <= largest_side) sides.push_back(side);
  }
  if (parts.size() != 2 || sides.size() != 2) {
    throw InputError(
        {"--size", "", "\"" + text + "\"", "WxH in pixels, each from 16 to 4096, such as 1280x960"});
  }
  return {sides[0], sides[1]};
}

std::vector<std::string> parsed_views(const std::string& text)
{
  std::string known;
  for (const std::string& name : view::view_names()) known += (known.empty() ? "" : ", ") + name;
  std::vector<std::string> views = split(text, ',');
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!view::view_named(views[i]))
      throw InputError({"--views", "", "\"" + views[i] + "\"", "some of " + known});
    if (std::find(views.begin(), views.begin() + static_cast<std::ptrdiff_t>(i), views[i]) !=
        views.begin() + static_cast<std::ptrdiff_t>(i)) {
      throw InputError({"--views", "", views[i] + " twice", "every view once"});
    }
  }
  return views;
}

std::string angle_label(double angle_deg, const std::vector<double>& others_deg)
{
  int decimals = decimals_of(angle_deg);
  for (const double other_deg : others_deg) decimals = std::max(decimals, decimals_of(other_deg));
  const int width = 3 + (decimals > 0 ? decimals + 1 : 0);
  char text[32];
  std::snprintf(text, sizeof text, "%0*.*f", width, decimals, angle_deg == 0.0 ? 0.0 : angle_deg);
  return text;
}

std::string plain_label(double angle_rad)
{
  const double angle_deg = deg_from_rad(angle_rad);
  std::string text = angle_label(angle_deg, {});
  const std::size_t first = text.find_first_not_of("-0");
  const bool is_whole_zero = first == std::string::npos || text[first] == '.';
  const std::string digits =
      is_whole_zero ? "0" + (first == std::string::npos ? "" : text.substr(first)) : text.substr(first);
  return (text[0] == '-' ? "-" : "") + digits;
}

void report_clamped(const store::Motion& motion, const store::JointPose& pose, const Attitude& wanted,
                    const char* used, std::ostream& messages)
{
  if (pose.is_flexion_clamped && is_beyond(wanted.flexion_rad, pose.attitude.flexion_rad)) {
    messages << "--flexion: found " << plain_label(wanted.flexion_rad) << ", wanted "
             << plain_label(motion.first_flexion_rad()) << " to " << plain_label(motion.last_flexion_rad())
             << " degrees: " << used << " at " << plain_label(pose.attitude.flexion_rad) << "\n";
  }
  if (pose.is_varus_clamped && motion.is_varus_free()) {
    messages << "--varus: found " << plain_label(wanted.varus_rad)
             << ", but this set has its own varus: " << used
             << " at that; --set raw has the varus of the grid, unless it was free\n";
  } else if (pose.is_varus_clamped && is_beyond(wanted.varus_rad, pose.attitude.varus_rad)) {
    messages << "--varus: found " << plain_label(wanted.varus_rad) << ", wanted "
             << plain_label(motion.first_varus_rad()) << " to " << plain_label(motion.last_varus_rad())
             << " degrees: " << used << " at " << plain_label(pose.attitude.varus_rad) << "\n";
  }
}

}  // namespace vrda::view
