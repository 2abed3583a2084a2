/// Time of a motion step by part. The linker redirects the callers of the rooms' entry functions
/// (CMakeLists.txt), so the product contains no timing code.
#pragma once

namespace vrda::benchmarks {

/// Seconds since reset_shares(), in this thread.
struct Shares {
  double gap_s = 0.0;        ///< proximity: directional gap
  double turn_s = 0.0;       ///< proximity: rotating the reference to its attitude
  double collision_s = 0.0;  ///< contact: collision
  double contacts_s = 0.0;   ///< contact: contact points
};

void reset_shares();
Shares shares();

}  // namespace vrda::benchmarks
