/// The mode `show` in a window.
#pragma once

#include <string>

#include "app/show.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Until the user closes it. `set` is one of set_names(model).
/// Throws InputError when there is no display, or for options that want pictures.
void show_in_window(const ShowOptions& options, MotionModel model, const std::string& set);

}  // namespace vrda
