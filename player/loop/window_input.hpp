/// Keys and buttons of a window as those that mean something.
#pragma once

#include <optional>

#include "render/window.hpp"
#include "view/keys.hpp"
#include "view/pointer.hpp"

namespace vrda {

/// Of InputEvent::key, which is the character without shift, and has_shift; Key::none for one that nothing
/// listens to.
Key key_of_window(int key, bool has_shift);

/// Nothing where the event is no press of a key that means something.
std::optional<KeyPress> key_press_of(const InputEvent& event);

Button button_of(MouseButton button);

}  // namespace vrda
