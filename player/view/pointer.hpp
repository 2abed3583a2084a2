/// Which button moves the object how (thesis 6.2.1), also for mice of two buttons and touchpads.
#pragma once

#include "view/gaze.hpp"

namespace vrda {

enum class Button { left, middle, right };

/// Left moves in the picture plane, middle turns, right moves in depth; with control the left button turns,
/// with shift it moves in depth.
DragKind drag_of(Button button, bool has_shift, bool has_control);

}  // namespace vrda
