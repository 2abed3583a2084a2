#include "devices/tracker_protocol.hpp"

#include <algorithm>

namespace vrda::devices {

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

namespace {

bool has_places(const igtl::IgtlMessage& message)
{
  return igtl::is_list(message) || message.kind == igtl::IgtlKind::transform ||
         message.kind == igtl::IgtlKind::position;
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

/// A repeated time stamp yields no sample: `kind` remains `link`.
Sample TrackerProtocol::observed_sample(Tool& tool, const igtl::IgtlTool* observed,
                                        const igtl::IgtlMessage& message, std::int64_t now_ns)
{
  Sample sample;
  const ToolMonitor::StampCheck how = tool.watch.receive_stamp(message.device_ns, now_ns);
  if (how == ToolMonitor::StampCheck::repeated) return sample;
  if (how == ToolMonitor::StampCheck::accepted) last_news_ns_ = now_ns;
  const ToolVisibility found = observed == nullptr ? ToolVisibility::missing : observed->visibility;
  const bool is_old = found == ToolVisibility::seen && how == ToolMonitor::StampCheck::behind;
  sample = sample_of(tool, is_old ? ToolVisibility::stale : found, now_ns);
  if (found == ToolVisibility::seen) sample.tool_pose = place_of(observed->X_tracker_tool);
  sample.device_ns = message.device_ns;
  return sample;
}

std::vector<Sample> TrackerProtocol::receive(const igtl::IgtlMessage& message, std::int64_t now_ns)
{
  std::vector<Sample> samples;
  for (Tool& tool : tools_) {
    const auto is_of_tool = [&tool](const igtl::IgtlTool& observed) { return observed.name == tool.name; };
    const auto observed = std::ranges::find_if(message.tools, is_of_tool);
    const bool is_left_out = igtl::is_list(message) && (!tool.was_received || tool.list == message.device);
    const bool is_called_missing = message.kind == igtl::IgtlKind::status &&
                                   message.code != igtl::igtl_status_ok && message.device == tool.name;
    const bool is_observed = has_places(message) && observed != message.tools.end();
    if (!is_observed && !is_left_out && !is_called_missing) continue;
    if (is_observed) {
      tool.was_received = true;
      tool.list = igtl::is_list(message) ? std::optional(message.device) : std::nullopt;
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

std::string error_text_of(const igtl::IgtlMessage& message)
{
  if (message.kind == igtl::IgtlKind::status && message.code != igtl::igtl_status_ok)
    return message.device + ": status " + std::to_string(message.code) + " (" + message.text + ")";
  if (message.kind == igtl::IgtlKind::tdata_started && message.code != 0)
    return message.device + ": refuses to stream TDATA";
  return "";
}

}  // namespace vrda::devices
