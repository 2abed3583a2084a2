// A window's events as what they mean for a session.
#include "loop/window_input.hpp"
#include "show/session.hpp"

namespace vrda {
namespace {

constexpr int frames_after_input = 3;  // buttons of the interface answer within two

}  // namespace

void Session::take_key(const InputEvent& event)
{
  const KeyPress press{key_of_window(event.key, event.has_shift), event.has_shift, event.has_control};
  const bool is_held = event.key == held_key_;
  held_key_ = event.key;
  if (!is_held || goes_on_while_held(action_of(press))) press_key(press);
}

void Session::take(const InputEvent& event)
{
  const Eigen::Vector2d pointer_px(event.x_px, event.y_px);
  n_frames_due_ = frames_after_input;
  switch (event.kind) {
    case InputKind::motion:
      return move(pointer_px);
    case InputKind::press:
      if (event.n_clicks == 2 && event.button == MouseButton::left) double_click(pointer_px);
      return press(button_of(event.button), pointer_px, event.has_shift, event.has_control);
    case InputKind::release:
      return release(button_of(event.button));
    case InputKind::wheel:
      move(pointer_px);
      return turn_wheel(event.wheel_y);
    case InputKind::key_press:
      return take_key(event);
    case InputKind::key_release:
      if (event.key == held_key_) held_key_ = 0;
      return;
    case InputKind::focus_lost:
      held_key_ = 0;
      // A release outside never comes.
      for (const Button button : {Button::left, Button::middle, Button::right}) release(button);
      return;
    default:
      return;
  }
}

}  // namespace vrda
