/// The One-Euro filter: strong smoothing at rest, little delay in motion.
/// Source: Casiez, Roussel, Vogel (2012) CHI, 2527-2530. Differs: the speed is computed from raw values
/// instead of filtered ones, which gives the delay a closed form.
#pragma once

#include "bench/leg.hpp"

namespace vrda::bench {

struct OneEuroOptions {
  double least_cutoff_hz = 1.0;  ///< at rest
  double hz_by_speed = 0.0;      ///< cutoff gained per unit of speed: rad/s, or counts/s
  double speed_cutoff_hz = 1.0;  ///< of the speed estimate
};

/// The delay at constant speed is 1 / (2 pi cutoff(speed)), at any sampling rate: 0.1 s at rest, 8 ms at 1
/// rad/s.
inline constexpr OneEuroOptions default_angle_filter{1.5, 18.0, 1.0};

/// Filter of a scalar. A repeated time changes nothing; an earlier time restarts the filter.
class OneEuroFilter {
 public:
  explicit OneEuroFilter(const OneEuroOptions& options) : options_(options) {}
  double filtered(double value, double time_s);
  void start_over() { has_last_ = false; }

 private:
  OneEuroOptions options_;
  bool has_last_ = false;
  double time_s_ = 0.0, raw_ = 0.0, speed_ = 0.0, value_ = 0.0;
};

/// Filters each of a leg's angles.
class OneEuroAngles {
 public:
  explicit OneEuroAngles(const OneEuroOptions& options = default_angle_filter)
      : flexion_(options), varus_(options), theta_(options)
  {
  }
  LegAngles filtered(const LegAngles& angles, double time_s);
  void start_over();

 private:
  OneEuroFilter flexion_, varus_, theta_;
};

}  // namespace vrda::bench
