#include "bench/tracker_protocol.hpp"

#include <algorithm>

namespace vrda::bench {

ToolMonitor::StampCheck ToolMonitor::receive_stamp(std::int64_t device_ns, std::int64_t now_ns)
{
  if (device_ns != 0 && device_ns == accepted_ns_) return StampCheck::repeated;
  if (device_ns != 0 && device_ns < accepted_ns_) {
    if (n_behind_ == 0 || device_ns < last_behind_ns_) {
      n_behind_ = 1;
    } else if (device_ns > last_behind_ns_) {
      ++n_behind_;
    }
    last_behind_ns_ = device_ns;
    if (n_behind_ < n_to_accept_clock) return StampCheck::behind;
  }
  accepted_ns_ = device_ns;
  n_behind_ = 0;
  last_news_ns_ = now_ns;
  return StampCheck::accepted;
}

bool ToolMonitor::becomes_stale(std::int64_t now_ns)
{
  if (now_ns - last_news_ns_ < stale_after_ns_) return false;
  last_news_ns_ = now_ns;
  return true;
}

PoseMonitor::PoseCheck PoseMonitor::receive(const ToolPose& pose, std::int64_t now_ns)
{
  const bool is_same = has_last_ && std::ranges::equal(pose.position_mm, last_.position_mm) &&
                       std::ranges::equal(pose.rotation, last_.rotation);
  if (!is_same) {
    has_changed_ = has_last_;
    has_last_ = true;
    last_ = pose;
    changed_ns_ = now_ns;
  }
  if (now_ns - changed_ns_ < frozen_after_ns) return PoseCheck::changing;
  const bool is_identity = pose_of(pose).isApprox(Pose::Identity(), 0.0);
  return has_changed_ || is_identity ? PoseCheck::frozen : PoseCheck::constant;
}

bool PoseMonitor::has_moved(const ToolPose& pose) const
{
  constexpr double rounding_mm = 1e-3, rounding_rad = 1e-5;
  const Pose X_last_pose = pose_of(last_).inverse() * pose_of(pose);
  return has_last_ && (X_last_pose.translation().norm() > rounding_mm ||
                       Eigen::AngleAxisd(X_last_pose.linear()).angle() > rounding_rad);
}

namespace {

bool has_places(const bench::IgtlMessage& message)
{
  return bench::is_list(message) || message.kind == bench::IgtlKind::transform ||
         message.kind == bench::IgtlKind::position;
}

}  // namespace

TrackerProtocol::TrackerProtocol(const TrackerSettings& settings, std::int64_t now_ns)
    : stale_after_ns_(static_cast<std::int64_t>(settings.stale_after_ms * 1e6)),
      last_news_ns_(now_ns - stale_after_ns_)
{
  for (const std::string& name : settings.tools)
    tools_.push_back({name, ToolMonitor(stale_after_ns_, now_ns)});
}

Sample TrackerProtocol::sample_of(const Tool& tool, ToolVisibility state, std::int64_t now_ns) const
{
  Sample sample;
  sample.kind = SampleKind::tool_pose;
  sample.arrival_ns = now_ns;
  sample.source = static_cast<std::uint16_t>(&tool - tools_.data());
  sample.state = static_cast<std::uint8_t>(state);
  return sample;
}

/// A stamp that does not advance counts against the clock if the pose moves: 8 in a row, or a share above a
/// ninth of all messages, and the arrival counts instead. One clock set back costs 7. `place`: of a seen
/// tool.
ToolMonitor::StampCheck TrackerProtocol::check_stamp(Tool& tool, const ToolPose* place,
                                                     std::int64_t device_ns, std::int64_t now_ns)
{
  constexpr int step = 8, most_doubt = step * ToolMonitor::n_to_accept_clock;
  has_no_stamps_ = has_no_stamps_ || device_ns == 0;
  if (!uses_arrival_) {
    const ToolMonitor::StampCheck how = tool.watch.receive_stamp(device_ns, now_ns);
    const bool has_moved = place != nullptr && tool.pose.has_moved(*place);
    has_gone_back_ = has_gone_back_ || (how == ToolMonitor::StampCheck::behind && has_moved);
    if (how == ToolMonitor::StampCheck::accepted)
      tool.doubt = std::max(0, tool.doubt - 1);
    else if (has_moved)
      tool.doubt += step;
    uses_arrival_ = tool.doubt >= most_doubt;
    if (!uses_arrival_) return how;
  }
  return tool.watch.receive_stamp(0, now_ns);
}

/// A repeated time stamp yields no sample: `kind` remains `link`.
Sample TrackerProtocol::observed_sample(Tool& tool, const bench::IgtlTool* observed,
                                        const bench::IgtlMessage& message, std::int64_t now_ns)
{
  using StampCheck = ToolMonitor::StampCheck;
  const ToolVisibility found = observed == nullptr ? ToolVisibility::missing : observed->visibility;
  const bool is_seen = found == ToolVisibility::seen;
  const ToolPose place = is_seen ? place_of(observed->X_tracker_tool) : ToolPose{};
  const StampCheck how = check_stamp(tool, is_seen ? &place : nullptr, message.device_ns, now_ns);
  // The rounding of two message types must not look like a change.
  if (is_seen && (how == StampCheck::accepted || tool.pose.has_moved(place))) {
    tool.numbers = tool.pose.receive(place, now_ns);
    tool.is_stated = observed->is_stated;
  }
  if (how == StampCheck::repeated) return {};
  if (how == StampCheck::accepted) last_news_ns_ = now_ns;
  const bool is_frozen = tool.numbers == PoseMonitor::PoseCheck::frozen && !tool.is_stated;
  const bool is_old = is_seen && (how == StampCheck::behind || is_frozen);
  Sample sample = sample_of(tool, is_old ? ToolVisibility::stale : found, now_ns);
  if (is_seen) sample.tool_pose = place;
  sample.device_ns = uses_arrival_ ? 0 : message.device_ns;
  return sample;
}

std::vector<Sample> TrackerProtocol::receive(const bench::IgtlMessage& message, std::int64_t now_ns)
{
  std::vector<Sample> samples;
  for (Tool& tool : tools_) {
    const auto is_of_tool = [&tool](const bench::IgtlTool& observed) { return observed.name == tool.name; };
    const auto observed = std::ranges::find_if(message.tools, is_of_tool);
    const bool is_left_out = bench::is_list(message) && (!tool.was_received || tool.list == message.device);
    const bool is_called_missing = message.kind == bench::IgtlKind::status &&
                                   message.code != bench::igtl_status_ok && message.device == tool.name;
    const bool is_observed = has_places(message) && observed != message.tools.end();
    if (!is_observed && !is_left_out && !is_called_missing) continue;
    if (is_observed) {
      tool.was_received = true;
      tool.list = bench::is_list(message) ? std::optional(message.device) : std::nullopt;
    }
    const Sample sample = observed_sample(tool, is_observed ? &*observed : nullptr, message, now_ns);
    if (sample.kind == SampleKind::tool_pose) samples.push_back(sample);
  }
  return samples;
}

std::vector<Sample> TrackerProtocol::stale_samples(std::int64_t now_ns)
{
  std::vector<Sample> samples;
  const bool has_news = now_ns - last_news_ns_ < stale_after_ns_;
  for (Tool& tool : tools_) {
    if (tool.watch.becomes_stale(now_ns))
      samples.push_back(sample_of(tool, has_news ? ToolVisibility::missing : ToolVisibility::stale, now_ns));
  }
  return samples;
}

void TrackerProtocol::begin_connection()
{
  for (Tool& tool : tools_) {
    tool.pose = {};
    tool.numbers = PoseMonitor::PoseCheck::changing;
    tool.doubt = 0;
  }
  uses_arrival_ = has_gone_back_ = has_no_stamps_ = false;
}

std::vector<std::string> TrackerProtocol::notes() const
{
  std::vector<std::string> notes;
  if (uses_arrival_)
    notes.emplace_back("the time stamps do not advance with the poses: arrival times are used");
  else if (has_gone_back_)
    notes.emplace_back("the time stamps went back: poses are used again once 8 in a row advance");
  if (has_no_stamps_) notes.emplace_back("the messages have no time stamps: arrival times are used");
  for (const Tool& tool : tools_) {
    if (tool.numbers == PoseMonitor::PoseCheck::frozen)
      notes.push_back(tool.name +
                      ": its numbers stay bit-identical for more than 0.5 s while messages arrive: " +
                      (tool.is_stated ? "the server states that it is visible, so it is shown"
                                      : "taken as hidden, because a measured pose jitters"));
    if (tool.numbers == PoseMonitor::PoseCheck::constant && !tool.is_stated)
      notes.push_back(tool.name +
                      ": its numbers have not changed since the connection began: a fixed or "
                      "simulated tool, or a hidden one (the server states no TransformStatus)");
  }
  return notes;
}

std::string error_text_of(const bench::IgtlMessage& message)
{
  if (message.kind == bench::IgtlKind::status && message.code != bench::igtl_status_ok)
    return message.device + ": status " + std::to_string(message.code) + " (" + message.text + ")";
  if (message.kind == bench::IgtlKind::tdata_started && message.code != 0)
    return message.device + ": refuses to stream TDATA";
  return "";
}

}  // namespace vrda::bench
