#include "bench/protocols.hpp"

#include <algorithm>

#include "bench/board.h"

namespace vrda::bench {
namespace {

constexpr std::size_t head_bytes = 4;  // start, request, length
constexpr std::size_t crc_bytes = 2;

static_assert(sizeof(SerialFrame::payload) == board_most_payload);

}  // namespace

void SerialFrameParser::add(std::span<const std::uint8_t> bytes)
{
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

/// Classifies the bytes at the front. A frame with an impossible header is noise before it is complete.
SerialFrameParser::ParseState SerialFrameParser::parse_state() const
{
  const std::span<const std::uint8_t> at = unparsed();
  if (at.empty()) return ParseState::incomplete;
  if (at[0] != board_frame_start_0 || (at.size() > 1 && at[1] != board_frame_start_1))
    return ParseState::noise;
  if (at.size() < head_bytes) return ParseState::incomplete;
  const std::size_t n = at[3];
  if (n > board_most_payload) return ParseState::noise;
  if (at.size() < head_bytes + n + crc_bytes) return ParseState::incomplete;
  const std::uint16_t crc = crc16(&at[2], n + 2);
  const bool is_right = at[head_bytes + n] == (crc & 0xFF) && at[head_bytes + n + 1] == crc >> 8;
  return is_right ? ParseState::frame : ParseState::noise;
}

std::optional<SerialFrame> SerialFrameParser::next()
{
  ParseState found = parse_state();
  for (; found == ParseState::noise; found = parse_state()) {
    if (!is_in_noise_) ++n_noises_;
    is_in_noise_ = true;
    ++begin_;
  }
  if (found == ParseState::incomplete) return std::nullopt;
  const std::span<const std::uint8_t> at = unparsed();
  SerialFrame frame;
  frame.request = static_cast<char>(at[2]);
  frame.n = at[3];
  std::copy_n(at.begin() + head_bytes, frame.n, frame.payload.begin());
  begin_ += head_bytes + frame.n + crc_bytes;
  is_in_noise_ = false;
  return frame;
}

namespace {

constexpr int largest_potentiometer = 1023;

std::int32_t count_of(const SerialFrame& frame)
{
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value |= static_cast<std::uint32_t>(frame.payload[k]) << (8 * k);
  return static_cast<std::int32_t>(value);
}

}  // namespace

BoardProtocol::BoardProtocol(const BoardSettings& settings, std::int64_t now_ns)
    : period_ns_(static_cast<std::int64_t>(1e9 / settings.rate_hz)), next_ns_(now_ns)
{
  if (settings.has_potentiometer) readings_.push_back({'P'});
  if (settings.has_stage) readings_.push_back({'E'});
}

void BoardProtocol::fail(const std::string& error_message)
{
  phase_ = Phase::failed;
  error_message_ = error_message;
}

std::string BoardProtocol::due_version(std::int64_t now_ns)
{
  if (now_ns < next_ns_) return "";
  if (n_version_requests_ == max_version_requests) {
    fail("found no answer to V for 5 s, wanted a board of protocol version " +
         std::to_string(board_protocol_version));
    return "";
  }
  ++n_version_requests_;
  next_ns_ = now_ns + request_timeout_ns;
  return "V";
}

/// The request, if fewer than two are outstanding in a round or the oldest has timed out.
std::string BoardProtocol::due_reading(Reading& reading, bool is_round, std::int64_t now_ns)
{
  const bool is_late = reading.n_outstanding > 0 && now_ns - reading.sent_ns[0] >= request_timeout_ns;
  if (is_late) {
    reading.n_outstanding = 0;
    if (now_ns - last_answer_ns_ >= board_timeout_ns) fail("found no answer for 1 s, wanted readings");
  }
  if (!is_late && !(is_round && reading.n_outstanding < 2)) return "";
  reading.sent_ns[static_cast<std::size_t>(reading.n_outstanding++)] = now_ns;
  return {reading.request};
}

std::string BoardProtocol::due(std::int64_t now_ns)
{
  if (phase_ == Phase::failed) return "";
  if (phase_ == Phase::requesting_version) return due_version(now_ns);
  std::string requests;
  if (is_zero_pending_ && now_ns >= zero_retry_ns_) {
    requests += 'Z';
    zero_retry_ns_ = now_ns + request_timeout_ns;
  }
  const bool is_round = now_ns >= next_ns_;
  for (Reading& reading : readings_) requests += due_reading(reading, is_round, now_ns);
  // Missed rounds are skipped.
  if (is_round) next_ns_ = next_ns_ + period_ns_ > now_ns ? next_ns_ + period_ns_ : now_ns + period_ns_;
  if (phase_ == Phase::failed) return "";
  return requests;
}

std::int64_t BoardProtocol::next_due_ns() const
{
  std::int64_t next_ns = next_ns_;
  for (const Reading& reading : readings_) {
    if (reading.n_outstanding > 0) next_ns = std::min(next_ns, reading.sent_ns[0] + request_timeout_ns);
  }
  return is_zero_pending_ ? std::min(next_ns, zero_retry_ns_) : next_ns;
}

void BoardProtocol::handle_version(const SerialFrame& frame, std::int64_t now_ns)
{
  const std::string tag(frame.payload.begin() + 1, frame.payload.begin() + 5);
  if (frame.n != 5 || tag != "VRDA") {
    fail("found another board's answer to V, wanted the version and VRDA");
  } else if (frame.payload[0] != board_protocol_version) {
    fail("found protocol version " + std::to_string(frame.payload[0]) + ", wanted " +
         std::to_string(board_protocol_version));
  } else {
    phase_ = Phase::up;
    next_ns_ = now_ns;
  }
}

/// False if the frame is not a valid reading.
bool BoardProtocol::handle_reading(const SerialFrame& frame, Sample& sample)
{
  const int value = frame.payload[0] | frame.payload[1] << 8;
  if (frame.request == 'P' && frame.n == 2 && value <= largest_potentiometer) {
    sample.kind = SampleKind::potentiometer;
    sample.count = value;
    return true;
  }
  if (frame.request == 'E' && frame.n == 5) {
    sample.kind = SampleKind::stage;
    sample.count = count_of(frame);
    sample.state = frame.payload[4] & (stage_zeroed | stage_lost_counts);
    return true;
  }
  return false;
}

std::vector<Sample> BoardProtocol::receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns)
{
  std::vector<Sample> samples;
  frames_.add(bytes);
  while (const std::optional<SerialFrame> frame = frames_.next()) {
    Sample sample;
    sample.arrival_ns = now_ns;
    if (frame->request == 'V') {
      if (phase_ == Phase::requesting_version) handle_version(*frame, now_ns);
    } else if (phase_ == Phase::up && frame->request == 'Z' && frame->n == 4) {
      is_zero_pending_ = false;
    } else if (phase_ == Phase::up && handle_reading(*frame, sample)) {
      samples.push_back(sample);
      for (Reading& reading : readings_) {
        if (reading.request != frame->request || reading.n_outstanding == 0) continue;
        reading.sent_ns[0] = reading.sent_ns[1];
        --reading.n_outstanding;
      }
    } else {
      if (phase_ == Phase::up) ++n_refused_;  // before that: maybe an answer to another program
      continue;
    }
    last_answer_ns_ = now_ns;
  }
  return samples;
}

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

bool has_places(const IgtlMessage& message)
{
  return is_list(message) || message.kind == IgtlKind::transform || message.kind == IgtlKind::position;
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
Sample TrackerProtocol::observed_sample(Tool& tool, const IgtlTool* observed, const IgtlMessage& message,
                                        std::int64_t now_ns)
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

std::vector<Sample> TrackerProtocol::receive(const IgtlMessage& message, std::int64_t now_ns)
{
  std::vector<Sample> samples;
  for (Tool& tool : tools_) {
    const auto is_of_tool = [&tool](const IgtlTool& observed) { return observed.name == tool.name; };
    const auto observed = std::ranges::find_if(message.tools, is_of_tool);
    const bool is_left_out = is_list(message) && (!tool.was_received || tool.list == message.device);
    const bool is_called_missing =
        message.kind == IgtlKind::status && message.code != igtl_status_ok && message.device == tool.name;
    const bool is_observed = has_places(message) && observed != message.tools.end();
    if (!is_observed && !is_left_out && !is_called_missing) continue;
    if (is_observed) {
      tool.was_received = true;
      tool.list = is_list(message) ? std::optional(message.device) : std::nullopt;
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

std::string error_text_of(const IgtlMessage& message)
{
  if (message.kind == IgtlKind::status && message.code != igtl_status_ok)
    return message.device + ": status " + std::to_string(message.code) + " (" + message.text + ")";
  if (message.kind == IgtlKind::tdata_started && message.code != 0)
    return message.device + ": refuses to stream TDATA";
  return "";
}

}  // namespace vrda::bench
