/// One tracked body: from samples of its tool, or of its markers, to where it stands at a time of our clock.
#pragma once

#include <cstdint>
#include <vector>

#include "devices/sample.hpp"
#include "setup/bench_file.hpp"
#include "tracking/body_pose.hpp"
#include "tracking/prediction.hpp"

namespace vrda {

/// What a device stamped arrives later by the way's delay, which varies; the smallest seen is taken for the
/// way itself. Clocks drift: it is forgotten by 0.1 ms a second.
class ClockMap {
 public:
  /// When the device took the sample, s of our clock; never later than its arrival, never earlier than the
  /// answer before. A device clock that steps (back at all, or ahead by more than a second) is met anew. Of
  /// 0, no clock: the arrival.
  double time_s(std::int64_t device_ns, std::int64_t arrival_ns);

 private:
  bool has_offset_ = false;
  std::int64_t offset_ns_ = 0;  ///< ours less the device's
  std::int64_t device_ns_ = 0, arrival_ns_ = 0;
  double time_s_ = 0.0;
};

class BodyTracker {
 public:
  /// The body's tools are those of the tracker from `first_tool` on, as BenchFile lists them.
  BodyTracker(const BodySettings& settings, std::size_t first_tool);

  bool has_markers() const { return has_markers_; }
  bool has_tool(std::size_t tool) const { return tool >= first_tool_ && tool < first_tool_ + n_tools_; }
  /// Whether that one of its tools has come since the last settle(): another sample of it belongs to the next
  /// message.
  bool has_come(std::size_t tool) const { return has_come_[tool - first_tool_]; }
  /// A sample of one of its tools, taken at `time_s` of our clock.
  void take(const Sample& sample, double time_s);
  /// Fits the markers taken since; true when there is a new pose. Wanted after all samples of a message.
  bool settle();
  /// The tracker is gone.
  void lose();

  bool was_seen() const { return has_last_; }
  bool is_live() const { return is_live_; }
  SeenState state() const { return state_; }
  /// When it was seen last, s of our clock.
  double seen_s() const { return last_.time_s; }
  /// Where it was seen last; identity when it never was.
  const Pose& last() const { return last_.X; }
  /// Where it is at `time_s` if it goes on as it did; a hidden body stays where it was seen last.
  Pose at(double time_s) const;
  /// Of the last fit of markers.
  const PoseFit& fit() const { return fit_; }

 private:
  void see(const TimedPose& pose);
  bool settle_markers();

  std::size_t first_tool_ = 0, n_tools_ = 1;
  std::vector<bool> has_come_;
  bool has_markers_ = false;
  RigidBody body_;
  Firing firing_;
  MarkerRow row_;  ///< since the last settle()
  bool has_row_ = false;
  double row_time_s_ = 0.0;
  bool has_new_pose_ = false;  ///< of a tool
  PoseFit fit_;
  Screw velocity_;  ///< of the last fit of markers: where the next begins
  PlacePredictor predictor_;
  TimedPose last_;
  bool has_last_ = false, is_live_ = false;
  SeenState state_ = SeenState::missing;
};

}  // namespace vrda
