/// Where the time of a motion step goes. The linker routes the callers of a room's entry functions through
/// here (CMakeLists.txt), so the product carries no clock.
#pragma once

namespace vrda::bench {

/// Seconds spent since reset_shares(), in this thread.
struct Shares {
  double gap_s = 0.0;        ///< proximity: directional gap
  double turn_s = 0.0;       ///< proximity: the reference turned to its attitude
  double collision_s = 0.0;  ///< contact: collision
  double contacts_s = 0.0;   ///< contact: contact points
};

void reset_shares();
Shares shares();

}  // namespace vrda::bench
