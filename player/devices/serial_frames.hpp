/// Frames of the serial protocol (schemas/serial-protocol.md) out of the bytes of a line.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace vrda {

struct SerialFrame {
  char request = 0;
  std::uint8_t n = 0;  ///< bytes of the payload
  std::array<std::uint8_t, 16> payload{};
  bool operator==(const SerialFrame&) const = default;
};

/// What is no frame is dropped byte by byte, so that noise costs the frame it hits and no other.
class SerialFrames {
 public:
  void add(std::span<const std::uint8_t> bytes);
  /// The next frame with a right checksum; nothing until more bytes come.
  std::optional<SerialFrame> next();
  /// Runs of bytes that belonged to no frame.
  std::uint64_t n_noises() const { return n_noises_; }

 private:
  enum class Look { frame, noise, more };
  Look look() const;
  std::span<const std::uint8_t> waiting() const { return std::span(buffer_).subspan(begin_); }

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  ///< of what is not used yet
  bool is_in_noise_ = false;
  std::uint64_t n_noises_ = 0;
};

}  // namespace vrda
