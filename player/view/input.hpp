/// Input events of a window as plain values.
#pragma once

namespace vrda::view {

/// Printable keys have the code of their character in the US layout, letters in upper case.
enum class Key : int {
  none = 0,  ///< every key not listed
  backspace = 8,
  enter = 13,
  escape = 27,
  space = ' ',
  up = 256,
  down,
  left,
  right,
  page_up,
  page_down,
  home,
  end,
  f1,
  f2,
  f3,
  f4,
  f5,
  f6,
  f11,
  f7,  // after f11: recordings contain the numbers
  f8
};

constexpr Key key_of(char character)
{
  return static_cast<Key>(character);
}

enum class MouseButton { left, right, middle };

enum class InputKind {
  motion,     ///< x_px, y_px
  press,      ///< button, n_clicks
  release,    ///< button
  wheel,      ///< wheel: notches, positive away from the user
  key_press,  ///< key; repeated while it is held
  key_release,
  focus_lost,
  drop,   ///< of files: see Window::dropped_files
  redraw  ///< a new size (which the renderer already has), the focus or the pointer has changed
};

/// Positions are in pixels from the top left corner of the window, for all kinds.
struct InputEvent {
  InputKind kind = InputKind::motion;
  double x_px = 0.0, y_px = 0.0;
  double wheel = 0.0;
  MouseButton button = MouseButton::left;
  int n_clicks = 1;     ///< 2 for the second of a double click
  Key key = Key::none;  ///< without shift: '/', not '?'
  bool has_shift = false, has_control = false;
};

/// State of a gamepad in the layout of an Xbox controller. Axes from -1 to 1: right and down are positive.
struct Gamepad {
  bool has_a = false, has_b = false, has_y = false;  ///< pressed buttons
  bool has_left_shoulder = false, has_right_shoulder = false;
  bool has_up = false, has_down = false, has_left = false, has_right = false;  ///< of the directional pad
  double stick_x = 0.0, stick_y = 0.0;                                         ///< left stick
};

}  // namespace vrda::view
