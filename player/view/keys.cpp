#include "view/keys.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <ostream>
#include <tuple>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "view/camera.hpp"

namespace vrda::view {
namespace {

struct Binding {
  Key key = Key::none;
  Action action = Action::none;
  Action with_shift = Action::none;  ///< none: shift makes no difference
};

// Generated from keys.json: bindings, key_lines, mouse_lines. Characters that some layouts need shift for (+)
// are listed without it.
#include "view/key_table.hpp"

void append(std::string& text, std::span<const HelpLine> lines)
{
  constexpr std::size_t column = 14;
  for (const HelpLine& line : lines) {
    const std::string keys = line.keys;
    text += "  " + keys + std::string(column - keys.size(), ' ') + line.description + "\n";
  }
}

}  // namespace

Action action_of(const KeyPress& press)
{
  if (press.has_control) return Action::none;
  const auto found = std::ranges::find(bindings, press.key, &Binding::key);
  if (found == bindings.end()) return Action::none;
  return press.has_shift && found->with_shift != Action::none ? found->with_shift : found->action;
}

bool repeats_while_held(Action action)
{
  constexpr std::array steps{Action::step_forward,
                             Action::step_back,
                             Action::leap_forward,
                             Action::leap_back,
                             Action::varus_up,
                             Action::varus_down,
                             Action::next_structure,
                             Action::previous_structure,
                             Action::less_opaque,
                             Action::more_opaque,
                             Action::section_forward,
                             Action::section_back,
                             Action::section_leap_forward,
                             Action::section_leap_back};
  return std::ranges::find(steps, action) != steps.end();
}

std::span<const HelpLine> key_help()
{
  return key_lines;
}

std::span<const HelpLine> mouse_help()
{
  return mouse_lines;
}

std::string help_text()
{
  std::string text = "Keys of the window:\n";
  append(text, key_lines);
  text += "Mouse:\n";
  append(text, mouse_lines);
  return text;
}

namespace {

constexpr double repeat_after_s = 0.4, repeat_every_s = 0.05;
/// Sticks at rest are off centre by up to a tenth.
constexpr double dead = 0.15, most_per_s = 60.0;

/// The number of presses due in the interval (from_s, to_s] of a held button.
int presses_in(double from_s, double to_s)
{
  const auto n = [](double s) {
    return s < repeat_after_s ? 0 : 1 + static_cast<int>(std::floor((s - repeat_after_s) / repeat_every_s));
  };
  return n(to_s) - n(from_s);
}

/// Presses per second by a deflection; fine near the middle.
double stick_rate(double deflection)
{
  const double beyond = std::clamp((std::abs(deflection) - dead) / (1.0 - dead), 0.0, 1.0);
  return std::copysign(most_per_s * beyond * beyond * beyond, deflection);
}

}  // namespace

const std::vector<KeyPress>& GamepadKeys::keys(const Gamepad& pad, double elapsed_s, bool is_plane)
{
  keys_.clear();
  if (!std::exchange(was_used_, true)) held_s_.fill(-1.0);
  const std::array<std::tuple<bool, Key, bool>, n_buttons> buttons{{{pad.has_left, Key::left, true},
                                                                    {pad.has_right, Key::right, true},
                                                                    {pad.has_up, Key::up, true},
                                                                    {pad.has_down, Key::down, true},
                                                                    {pad.has_a, Key::enter, false},
                                                                    {pad.has_b, Key::backspace, false},
                                                                    {pad.has_y, key_of('H'), false}}};
  for (std::size_t k = 0; k < n_buttons; ++k) {
    const auto& [is_pressed, key, repeats] = buttons[k];
    const double before_s = held_s_[k];
    held_s_[k] = !is_pressed ? -1.0 : before_s < 0.0 ? 0.0 : before_s + elapsed_s;
    int n = is_pressed && before_s < 0.0 ? 1 : 0;
    if (is_pressed && before_s >= 0.0 && repeats) n = presses_in(before_s, held_s_[k]);
    keys_.insert(keys_.end(), static_cast<std::size_t>(n),
                 {key, repeats && pad.has_left_shoulder, repeats && pad.has_right_shoulder});
  }
  const auto steer = [&](double deflection, double& due, Key less, Key more) {
    const double rate = stick_rate(deflection);
    due = rate == 0.0 ? 0.0 : due + rate * elapsed_s;
    for (; std::abs(due) >= 1.0; due -= std::copysign(1.0, due)) keys_.push_back({due < 0.0 ? less : more});
  };
  steer(pad.stick_x, due_[0], Key::left, Key::right);
  if (is_plane) steer(pad.stick_y, due_[1], Key::up, Key::down);
  return keys_;
}

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

std::optional<double> parsed_number(const std::string& text)
{
  return whole_number<double>(text);
}

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
  for (const std::string& name : view_names()) known += (known.empty() ? "" : ", ") + name;
  std::vector<std::string> views = split(text, ',');
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!view_named(views[i])) throw InputError({"--views", "", "\"" + views[i] + "\"", "some of " + known});
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
