/// The One-Euro filter: strong smoothing at rest, little delay in motion.
/// Source: Casiez, Roussel, Vogel (2012) CHI, 2527-2530. Differs: the speed is computed from raw values
/// instead of filtered ones, which gives the delay a closed form.
#pragma once

#include "tracking/leg.hpp"

namespace vrda::tracking {

struct OneEuroOptions {
  double least_cutoff_hz = 1.0;  ///< at rest
  double hz_by_speed = 0.0;      ///< cutoff gained per unit of speed: rad/s, or mm/s
  double speed_cutoff_hz = 1.0;  ///< of the speed estimate
};

/// The delay at constant speed is 1 / (2 pi cutoff(speed)), at any sampling rate: 0.1 s at rest, 8 ms at 1
/// rad/s.
inline constexpr OneEuroOptions default_angle_filter{1.5, 18.0, 1.0};
/// 0.1 s at rest, 9 ms at 300 mm/s.
inline constexpr OneEuroOptions default_position_filter{1.5, 0.05, 1.0};

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

struct PoseFilterOptions {
  OneEuroOptions position = default_position_filter;
  OneEuroOptions rotation = default_angle_filter;
};

/// Filters a pose: the position as a vector with one cutoff from its speed; the rotation along the shortest
/// rotation from the filtered one, in its tangent space.
class OneEuroPose {
 public:
  explicit OneEuroPose(const PoseFilterOptions& options = {}) : options_(options) {}
  Pose filtered(const Pose& X, double time_s);
  void start_over() { has_last_ = false; }

 private:
  PoseFilterOptions options_;
  bool has_last_ = false;
  double time_s_ = 0.0;
  Pose raw_ = Pose::Identity(), value_ = Pose::Identity();
  Eigen::Vector3d speed_mm_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d speed_rad_s_ = Eigen::Vector3d::Zero();  ///< in the tracker's axes
};

}  // namespace vrda::tracking
