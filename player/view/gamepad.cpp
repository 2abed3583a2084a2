#include "view/gamepad.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace vrda::view {
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

const std::vector<KeyPress>& GamepadKeys::keys(const view::Gamepad& pad, double elapsed_s, bool is_plane)
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

}  // namespace vrda::view
