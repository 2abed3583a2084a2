/// The keys of a window as those that mean something.
#pragma once

#include "view/keys.hpp"

namespace vrda {

/// Of InputEvent::key, which is the character without shift, and has_shift; Key::none for one that nothing
/// listens to.
Key key_of_window(int key, bool has_shift);

}  // namespace vrda
