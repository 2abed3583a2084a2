#include "bench/body_tracker.hpp"

#include <algorithm>
#include <optional>

#include "core/units.hpp"

namespace vrda::bench {
namespace {

constexpr std::int64_t clock_step_ns = 1'000'000'000;
constexpr std::int64_t drift_divisor = 10'000;  // 0.1 ms a second

}  // namespace

double ClockMap::time_s(std::int64_t device_ns, std::int64_t arrival_ns)
{
  if (device_ns == 0) {
    time_s_ = std::max(time_s_, static_cast<double>(arrival_ns) * s_per_ns);
    return time_s_;
  }
  const std::int64_t offset_ns = arrival_ns - device_ns;
  const bool is_back = has_offset_ && device_ns < device_ns_;
  const bool is_far_ahead = has_offset_ && offset_ns < offset_ns_ - clock_step_ns;
  if (!has_offset_ || is_back || is_far_ahead) {
    offset_ns_ = offset_ns;
    has_offset_ = true;
  } else {
    const std::int64_t relaxed_ns = (arrival_ns - arrival_ns_) / drift_divisor;
    offset_ns_ = std::min(offset_ns_ + relaxed_ns, offset_ns);
  }
  device_ns_ = device_ns;
  arrival_ns_ = arrival_ns;
  const std::int64_t local_ns = std::min(device_ns + offset_ns_, arrival_ns);
  time_s_ = std::max(time_s_, static_cast<double>(local_ns) * s_per_ns);
  return time_s_;
}

BodyTracker::BodyTracker(const bench::BodySettings& settings, std::size_t first_tool)
    : first_tool_(first_tool), n_tools_(bench::n_tools(settings)), has_markers_(settings.tool.empty())
{
  if (has_markers_) n_tools_ = settings.markers.size();
  has_come_.resize(n_tools_);
  if (!has_markers_) return;
  body_.markers_mm.resize(static_cast<Eigen::Index>(n_tools_), 3);
  for (std::size_t k = 0; k < n_tools_; ++k)
    body_.markers_mm.row(static_cast<Eigen::Index>(k)) = settings.markers_body_mm[k].transpose();
  firing_.interval_s = settings.marker_interval_ms / 1000.0;
  row_.resize(n_tools_);
}

void BodyTracker::take(const bench::Sample& sample, double time_s)
{
  has_come_[sample.source - first_tool_] = true;
  const auto state = static_cast<bench::ToolVisibility>(sample.state);
  if (!has_markers_) {
    state_ = state;
    is_live_ = state == bench::ToolVisibility::seen;
    if (is_live_) see({time_s, bench::pose_of(sample.tool_pose)});
    has_new_pose_ = has_new_pose_ || is_live_;
    return;
  }
  std::optional<Eigen::Vector3d>& marker = row_[sample.source - first_tool_];
  marker.reset();
  if (state == bench::ToolVisibility::seen) marker = Eigen::Vector3d::Map(sample.tool_pose.position_mm);
  // Stamps may be of the frame or of each marker's firing; the frame time is the earliest.
  row_time_s_ = has_row_ ? std::min(row_time_s_, time_s) : time_s;
  has_row_ = true;
}

bool BodyTracker::end_message()
{
  std::fill(has_come_.begin(), has_come_.end(), false);
  if (has_markers_) return has_row_ && settle_markers();
  const bool is_new = has_new_pose_;
  has_new_pose_ = false;
  return is_new;
}

bool BodyTracker::settle_markers()
{
  std::optional<bench::BodyMotion> before;
  if (has_last_) before = bench::BodyMotion{last_, velocity_};
  const bench::FiredFit fired = bench::fit_fired(body_, row_, row_time_s_, before, firing_);
  fit_ = fired.fit;
  velocity_ = fired.velocity;
  has_row_ = false;
  std::fill(row_.begin(), row_.end(), std::nullopt);
  is_live_ = fit_.status == bench::FitStatus::fitted;
  state_ = is_live_ ? bench::ToolVisibility::seen
                    : (fit_.status == bench::FitStatus::too_few_markers
                           ? bench::ToolVisibility::missing
                           : bench::ToolVisibility::invalid_pose);
  if (is_live_) see({row_time_s_, fit_.X_tracker_body});
  return is_live_;
}

void BodyTracker::see(const bench::TimedPose& pose)
{
  // After a long occlusion the velocity is unknown.
  constexpr double longest_gap_s = 0.25;
  if (has_last_ && pose.time_s - last_.time_s > longest_gap_s) predictor_.start_over();
  predictor_.add(pose);
  last_ = pose;
  has_last_ = true;
}

void BodyTracker::disconnect()
{
  is_live_ = false;
  state_ = bench::ToolVisibility::stale;
}

Pose BodyTracker::at(double time_s) const
{
  return is_live_ && predictor_.has_sample() ? predictor_.at(time_s) : last_.X;
}

TrackedBodies::TrackedBodies(const bench::BenchFile& bench)
{
  for (std::size_t k = 0; k < bench::n_body_roles; ++k) {
    const std::optional<bench::BodySettings>& body = bench.bodies[k];
    if (!body || body->markers_body_mm.size() != body->markers.size()) continue;
    trackers_[k].emplace(*body, bench::first_tool_index(bench, static_cast<bench::BodyRole>(k)));
  }
}

void TrackedBodies::disconnect()
{
  for (std::optional<BodyTracker>& tracker : trackers_) {
    if (tracker) tracker->disconnect();
  }
}

}  // namespace vrda::bench
