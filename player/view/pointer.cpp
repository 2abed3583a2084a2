#include "view/pointer.hpp"

namespace vrda {

DragKind drag_of(Button button, bool has_shift, bool has_control)
{
  switch (button) {
    case Button::left:
      if (has_control) return DragKind::rotate;
      return has_shift ? DragKind::depth : DragKind::translate;
    case Button::middle:
      return DragKind::rotate;
    case Button::right:
      return DragKind::depth;
  }
  return DragKind::translate;
}

}  // namespace vrda
