#include "bench/board_protocol.hpp"

#include <algorithm>

extern "C" {
#include "bench/board.h"
#include "bench/crc16.h"
}

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

}  // namespace vrda::bench
