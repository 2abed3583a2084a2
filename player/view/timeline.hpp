/// Flexion as it plays. No clock: the time that went by is an argument.
#pragma once

#include "core/units.hpp"

namespace vrda {

enum class LoopMode {
  once,   ///< stops at the end
  wrap,   ///< goes on from the other end
  bounce  ///< turns round
};

const char* name_of(LoopMode mode);

inline constexpr double slowest_rad_s = rad_from_deg(1.0), fastest_rad_s = rad_from_deg(360.0);

struct Timeline {
  double first_rad = 0.0, last_rad = 0.0;   ///< first <= last
  double flexion_rad = 0.0;                 ///< within them
  double speed_rad_s = rad_from_deg(30.0);  ///< within slowest and fastest
  int direction = 1;                        ///< 1 or -1; -1 only on the way back of a bounce
  bool is_playing = false;
  LoopMode loop = LoopMode::bounce;
};

/// After `elapsed_s` (not negative; a huge one is a valid one). Exact for any length: two halves of a time
/// lead where the whole of it does, to rounding.
Timeline advanced(Timeline timeline, double elapsed_s);

/// Played or paused the other way; at the end of `once` it begins again.
Timeline toggled(Timeline timeline);

/// Paused, further by `by_rad`, within the range.
Timeline stepped(Timeline timeline, double by_rad);

/// At `flexion_rad`, within the range; plays on if it plays.
Timeline moved_to(Timeline timeline, double flexion_rad);

/// With another range: flexion is kept where it can be.
Timeline with_range(Timeline timeline, double first_rad, double last_rad);

/// The next speed up or down of 1, 2, 5, 10, 20, 30, 45, 60, 90, 180, 360 degrees a second.
Timeline faster(Timeline timeline);
Timeline slower(Timeline timeline);

}  // namespace vrda
