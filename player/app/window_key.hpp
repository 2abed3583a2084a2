/// The keys of a window as those that mean something.
#pragma once

#include "view/keys.hpp"

namespace vrda {

/// Of InputEvent::key; Key::none for one that nothing listens to.
Key key_of_window(int key);

}  // namespace vrda
