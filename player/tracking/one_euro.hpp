/// The One-Euro filter: smooth while something rests, quick while it moves.
/// Source: Casiez, Roussel, Vogel (2012) CHI, 2527-2530. Differs: the speed is taken from raw values, not
/// from the filtered one, so that the delay has a closed form.
#pragma once

#include "tracking/leg.hpp"

namespace vrda {

struct OneEuroOptions {
  double least_cutoff_hz = 1.0;  ///< at rest
  double hz_by_speed = 0.0;      ///< cutoff gained by each unit of speed: rad/s, or mm/s
  double speed_cutoff_hz = 1.0;  ///< of the speed itself
};

/// By how much what moves at a steady speed lags behind: 1 / (2 pi cutoff(speed)), at any sampling rate.
double added_delay_s(const OneEuroOptions& options, double speed);

/// 0.1 s at rest, 8 ms at 1 rad/s.
inline constexpr OneEuroOptions default_angle_filter{1.5, 18.0, 1.0};
/// 0.1 s at rest, 9 ms at 300 mm/s.
inline constexpr OneEuroOptions default_position_filter{1.5, 0.05, 1.0};

/// Of one number. A time equal to the last changes nothing; an earlier one starts over.
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

/// Of a leg's angles, each by itself.
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

struct PlaceFilterOptions {
  OneEuroOptions position = default_position_filter;
  OneEuroOptions rotation = default_angle_filter;
};

/// Of a place: its position as a vector, with one cutoff from its speed; its rotation along the shortest turn
/// from the filtered one, in the tangent there.
class OneEuroPlace {
 public:
  explicit OneEuroPlace(const PlaceFilterOptions& options = {}) : options_(options) {}
  Pose filtered(const Pose& X, double time_s);
  void start_over() { has_last_ = false; }

 private:
  PlaceFilterOptions options_;
  bool has_last_ = false;
  double time_s_ = 0.0;
  Pose raw_ = Pose::Identity(), value_ = Pose::Identity();
  Eigen::Vector3d speed_mm_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d speed_rad_s_ = Eigen::Vector3d::Zero();  ///< in the tracker's axes
};

}  // namespace vrda
