#include "devices/serial_frames.hpp"

#include <algorithm>

extern "C" {
#include "firmware/board.h"
#include "firmware/crc16.h"
}

namespace vrda {
namespace {

constexpr std::size_t head_bytes = 4;  // start, request, length
constexpr std::size_t crc_bytes = 2;

static_assert(sizeof(SerialFrame::payload) == board_most_payload);

}  // namespace

void SerialFrames::add(std::span<const std::uint8_t> bytes)
{
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

/// What stands at the front. A frame that cannot be one any more is noise before it has ended.
SerialFrames::Look SerialFrames::look() const
{
  const std::span<const std::uint8_t> at = waiting();
  if (at.empty()) return Look::more;
  if (at[0] != board_frame_start_0 || (at.size() > 1 && at[1] != board_frame_start_1)) return Look::noise;
  if (at.size() < head_bytes) return Look::more;
  const std::size_t n = at[3];
  if (n > board_most_payload) return Look::noise;
  if (at.size() < head_bytes + n + crc_bytes) return Look::more;
  const std::uint16_t crc = crc16(&at[2], n + 2);
  const bool is_right = at[head_bytes + n] == (crc & 0xFF) && at[head_bytes + n + 1] == crc >> 8;
  return is_right ? Look::frame : Look::noise;
}

std::optional<SerialFrame> SerialFrames::next()
{
  Look found = look();
  for (; found == Look::noise; found = look()) {
    if (!is_in_noise_) ++n_noises_;
    is_in_noise_ = true;
    ++begin_;
  }
  if (found == Look::more) return std::nullopt;
  const std::span<const std::uint8_t> at = waiting();
  SerialFrame frame;
  frame.request = static_cast<char>(at[2]);
  frame.n = at[3];
  std::copy_n(at.begin() + head_bytes, frame.n, frame.payload.begin());
  begin_ += head_bytes + frame.n + crc_bytes;
  is_in_noise_ = false;
  return frame;
}

}  // namespace vrda
