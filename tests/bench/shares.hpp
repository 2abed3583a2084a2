/// Time of a motion step by part. The linker redirects the callers of the rooms' entry functions and of
/// Bullet (CMakeLists.txt), so the product contains no timing code.
#pragma once

namespace vrda::benchmarks {

/// Wall-clock seconds since reset_shares(), summed over all threads.
struct Shares {
  double gap_s = 0.0;        ///< proximity: gap queries
  double turn_s = 0.0;       ///< proximity: rotating the reference to its attitude
  double collision_s = 0.0;  ///< contact: collision, with its gap query and narrow phase
  double contacts_s = 0.0;   ///< contact: contact points, with their narrow phase
  double bullet_s = 0.0;     ///< Bullet's pair detector, in collision and contacts
};

/// Not while another thread solves.
void reset_shares();
Shares shares();

}  // namespace vrda::benchmarks
