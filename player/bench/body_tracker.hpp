/// Tracked body: pose at a time of the local clock from samples of its tool or markers.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/bench_file.hpp"
#include "core/units.hpp"
#include "bench/sample.hpp"
#include "bench/body_pose.hpp"
#include "bench/prediction.hpp"

namespace vrda::bench {

/// Maps device time stamps to the local clock. The offset is the smallest observed arrival delay; it is
/// relaxed by 0.1 ms a second to follow clock drift.
class ClockMap {
 public:
  /// Sampling time, s of the local clock; not later than the arrival and not earlier than the previous
  /// result. The offset is reset if the device clock steps back, or ahead by more than 1 s. Stamp 0 (no
  /// clock): the arrival.
  double time_s(std::int64_t device_ns, std::int64_t arrival_ns);

 private:
  bool has_offset_ = false;
  std::int64_t offset_ns_ = 0;  ///< local minus device clock
  std::int64_t device_ns_ = 0, arrival_ns_ = 0;
  double time_s_ = 0.0;
};

class BodyTracker {
 public:
  /// `first_tool`: index of the body's first tool in the order of BenchFile.
  BodyTracker(const bench::BodySettings& settings, std::size_t first_tool);

  bool has_markers() const { return has_markers_; }
  bool has_tool(std::size_t tool) const { return tool >= first_tool_ && tool < first_tool_ + n_tools_; }
  /// Whether the tool was received since the last end_message(); its next sample starts a new message.
  bool has_received(std::size_t tool) const { return has_come_[tool - first_tool_]; }
  /// Adds a sample of one of the body's tools, measured at `time_s` of the local clock.
  void take(const bench::Sample& sample, double time_s);
  /// Ends a message: fits the markers received since the last call. Returns true if there is a new pose.
  bool end_message();
  /// The tracker is disconnected.
  void disconnect();

  bool was_seen() const { return has_last_; }
  bool is_live() const { return is_live_; }
  bench::ToolVisibility state() const { return state_; }
  /// Time of the last pose, s of the local clock.
  double seen_s() const { return last_.time_s; }
  /// Last pose; identity before the first one.
  const Pose& last() const { return last_.X; }
  /// Pose extrapolated to `time_s`; the last pose if the body is hidden.
  Pose at(double time_s) const;
  /// Last fit of the markers.
  const bench::PoseFit& fit() const { return fit_; }

 private:
  void see(const bench::TimedPose& pose);
  bool settle_markers();

  std::size_t first_tool_ = 0, n_tools_ = 1;
  std::vector<bool> has_come_;
  bool has_markers_ = false;
  bench::RigidBody body_;
  bench::Firing firing_;
  bench::MarkerRow row_;  ///< markers since the last end_message()
  bool has_row_ = false;
  double row_time_s_ = 0.0;
  bool has_new_pose_ = false;  ///< tool only
  bench::PoseFit fit_;
  bench::Screw velocity_;  ///< of the last marker fit: start value of the next
  bench::PosePredictor predictor_;
  bench::TimedPose last_;
  bool has_last_ = false, is_live_ = false;
  bench::ToolVisibility state_ = bench::ToolVisibility::missing;
};

/// The trackers of a bench's bodies, by role, and the clock of the tracker.
class TrackedBodies {
 public:
  /// Without bodies of markers whose positions are unknown.
  explicit TrackedBodies(const bench::BenchFile& bench);

  std::optional<BodyTracker>& operator[](bench::BodyRole role)
  {
    return trackers_[static_cast<std::size_t>(role)];
  }
  const std::optional<BodyTracker>& operator[](bench::BodyRole role) const
  {
    return trackers_[static_cast<std::size_t>(role)];
  }

  /// Passes a tool's sample to its body; calls `end_message(tracker)` before a sample that starts the body's
  /// next message. Returns the time of the sample on the local clock; hidden tools do not update the clock.
  template <typename EndMessage>
  double take(const bench::Sample& sample, EndMessage end_message)
  {
    const double time_s = sample.is(bench::ToolVisibility::seen)
                              ? clock_.time_s(sample.device_ns, sample.arrival_ns)
                              : static_cast<double>(sample.arrival_ns) * s_per_ns;
    for (std::optional<BodyTracker>& tracker : trackers_) {
      if (!tracker || !tracker->has_tool(sample.source)) continue;
      if (tracker->has_received(sample.source)) end_message(*tracker);
      tracker->take(sample, time_s);
    }
    return time_s;
  }
  /// The tracker is disconnected.
  void disconnect();

 private:
  std::array<std::optional<BodyTracker>, bench::n_body_roles> trackers_;
  ClockMap clock_;
};

}  // namespace vrda::bench
