/// Key presses from the state of a gamepad, so that it turns the same numbers as keys and wheel.
#pragma once

#include <array>
#include <vector>

#include "view/keys.hpp"

namespace vrda::view {

class GamepadKeys {
 public:
  /// Key presses since the previous call, `elapsed_s` ago; valid until the next. The directional pad presses
  /// arrow keys, repeated while it is held, with the left shoulder as Shift and the right one as Control. The
  /// stick presses Left and Right up to 60 times a second, and, if it is `is_plane`, Up and Down. A is Enter,
  /// B Backspace, Y H.
  const std::vector<KeyPress>& keys(const view::Gamepad& pad, double elapsed_s, bool is_plane);

 private:
  static constexpr std::size_t n_buttons = 7;
  std::vector<KeyPress> keys_;
  std::array<double, n_buttons> held_s_{};   ///< since the press; negative: not pressed
  std::array<double, 2> due_{};              ///< parts of a press by the stick: x, y
  bool was_used_ = false;
};

}  // namespace vrda::view
