#include "devices/tracker_talk.hpp"

#include <algorithm>

namespace vrda {

ToolWatch::Heard ToolWatch::hear(std::int64_t device_ns, std::int64_t now_ns)
{
  if (device_ns != 0 && device_ns == accepted_ns_) return Heard::repeated;
  if (device_ns != 0 && device_ns < accepted_ns_) {
    if (n_behind_ == 0 || device_ns < last_behind_ns_) {
      n_behind_ = 1;
    } else if (device_ns > last_behind_ns_) {
      ++n_behind_;
    }
    last_behind_ns_ = device_ns;
    if (n_behind_ < n_to_believe) return Heard::behind;
  }
  accepted_ns_ = device_ns;
  n_behind_ = 0;
  last_news_ns_ = now_ns;
  return Heard::counts;
}

bool ToolWatch::falls_stale(std::int64_t now_ns)
{
  if (now_ns - last_news_ns_ < stale_after_ns_) return false;
  last_news_ns_ = now_ns;
  return true;
}

namespace {

bool has_places(const IgtlMessage& message)
{
  return is_list(message) || message.kind == IgtlKind::transform || message.kind == IgtlKind::position;
}

}  // namespace

TrackerTalk::TrackerTalk(const TrackerSettings& settings, std::int64_t now_ns)
{
  const auto stale_after_ns = static_cast<std::int64_t>(settings.stale_after_ms * 1e6);
  for (const std::string& name : settings.tools) tools_.push_back({name, ToolWatch(stale_after_ns, now_ns)});
}

Sample TrackerTalk::sample_of(const Tool& tool, SeenState state, std::int64_t now_ns) const
{
  Sample sample;
  sample.kind = SampleKind::place;
  sample.arrival_ns = now_ns;
  sample.source = static_cast<std::uint16_t>(&tool - tools_.data());
  sample.state = static_cast<std::uint8_t>(state);
  return sample;
}

/// A repeated time stamp yields no sample: `kind` remains `link`.
Sample TrackerTalk::observed_sample(Tool& tool, const IgtlTool& observed, const IgtlMessage& message,
                                    std::int64_t now_ns) const
{
  tool.was_received = true;
  tool.list = is_list(message) ? std::optional(message.device) : std::nullopt;
  Sample sample;
  if (observed.sight == IgtlSight::seen) {
    const ToolWatch::Heard how = tool.watch.hear(message.device_ns, now_ns);
    if (how == ToolWatch::Heard::repeated) return sample;
    sample = sample_of(tool, how == ToolWatch::Heard::counts ? SeenState::seen : SeenState::stale, now_ns);
    sample.place = place_of(observed.X_tracker_tool);
  } else {
    tool.watch.hear_missing(now_ns);
    sample = sample_of(
        tool, observed.sight == IgtlSight::missing ? SeenState::missing : SeenState::not_a_place, now_ns);
  }
  sample.device_ns = message.device_ns;
  return sample;
}

std::vector<Sample> TrackerTalk::hear(const IgtlMessage& message, std::int64_t now_ns)
{
  std::vector<Sample> samples;
  for (Tool& tool : tools_) {
    const auto is_of_tool = [&tool](const IgtlTool& observed) { return observed.name == tool.name; };
    const auto observed = std::find_if(message.tools.begin(), message.tools.end(), is_of_tool);
    const bool is_left_out = is_list(message) && (!tool.was_received || tool.list == message.device);
    const bool is_called_missing =
        message.kind == IgtlKind::status && message.code != igtl_status_ok && message.device == tool.name;
    if (has_places(message) && observed != message.tools.end()) {
      const Sample sample = observed_sample(tool, *observed, message, now_ns);
      if (sample.kind == SampleKind::place) samples.push_back(sample);
    } else if (is_left_out || is_called_missing) {
      tool.watch.hear_missing(now_ns);
      samples.push_back(sample_of(tool, SeenState::missing, now_ns));
      samples.back().device_ns = message.device_ns;
    }
  }
  return samples;
}

std::vector<Sample> TrackerTalk::pass_time(std::int64_t now_ns)
{
  std::vector<Sample> samples;
  for (Tool& tool : tools_) {
    if (tool.watch.falls_stale(now_ns)) samples.push_back(sample_of(tool, SeenState::stale, now_ns));
  }
  return samples;
}

std::string trouble_of(const IgtlMessage& message)
{
  if (message.kind == IgtlKind::status && message.code != igtl_status_ok)
    return message.device + ": status " + std::to_string(message.code) + " (" + message.text + ")";
  if (message.kind == IgtlKind::tdata_started && message.code != 0)
    return message.device + ": refuses to stream TDATA";
  return "";
}

}  // namespace vrda
