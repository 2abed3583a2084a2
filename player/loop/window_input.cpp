#include "loop/window_input.hpp"

namespace vrda {

Key key_of_window(int key, bool has_shift)
{
  constexpr int keypad_minus = 333, keypad_plus = 334, last_f = key_f1 + 5, f11 = key_f1 + 10;
  if (key >= key_f1 && key <= last_f) return static_cast<Key>(static_cast<int>(Key::f1) + key - key_f1);
  switch (key) {
    case key_escape:
      return Key::escape;
    case key_enter:
    case key_keypad_enter:
      return Key::enter;
    case key_backspace:
      return Key::backspace;
    case key_up:
      return Key::up;
    case key_down:
      return Key::down;
    case key_left:
      return Key::left;
    case key_right:
      return Key::right;
    case key_page_up:
      return Key::page_up;
    case key_page_down:
      return Key::page_down;
    case key_home:
      return Key::home;
    case key_end:
      return Key::end;
    case f11:
      return Key::f11;
    case keypad_minus:
      return key_of('-');
    case keypad_plus:
      return key_of('+');
    case '/':
      return key_of(has_shift ? '?' : '/');
    default:
      return key > ' ' - 1 && key < 127 ? static_cast<Key>(key) : Key::none;
  }
}

std::optional<KeyPress> key_press_of(const InputEvent& event)
{
  if (event.kind != InputKind::key_press) return std::nullopt;
  const Key key = key_of_window(event.key, event.has_shift);
  if (key == Key::none) return std::nullopt;
  return KeyPress{key, event.has_shift, event.has_control};
}

Button button_of(MouseButton button)
{
  switch (button) {
    case MouseButton::left:
      return Button::left;
    case MouseButton::middle:
      return Button::middle;
    case MouseButton::right:
      return Button::right;
  }
  return Button::left;
}

}  // namespace vrda
