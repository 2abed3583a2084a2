/// The mode `follow` in a window.
#pragma once

#include "app/follow.hpp"

namespace vrda {

/// Until the user closes it; a finished run is shown as it moves. Throws InputError when there is no display,
/// and like follow().
FollowEnd follow_in_window(const FollowOptions& options, StepChoice choice, const FollowStreams& streams);

}  // namespace vrda
