/// The buttons of a window as those that move the joint.
#pragma once

#include "render/window.hpp"
#include "view/pointer.hpp"

namespace vrda {

inline Button button_of(MouseButton button)
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
