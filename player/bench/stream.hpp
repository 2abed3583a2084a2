/// Splits the bytes of a connection into OpenIGTLink messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/message.hpp"

namespace vrda::bench {

/// The protocol has no start marker: after an invalid header or a wrong checksum the rest cannot be parsed. A
/// checksum of 0 means that the sender computes no checksum.
/// The stream is then broken, and the connection must be reopened.
class IgtlStream {
 public:
  /// Largest stored body: 900 tools of TDATA. Checked before allocation.
  static constexpr std::uint64_t max_body_bytes = 64 * 1024;
  /// Largest skipped body (images); a larger one means a corrupt header.
  static constexpr std::uint64_t max_skipped_bytes = 1ULL << 32;

  void add(std::span<const std::uint8_t> bytes);

  /// The next complete message of a known kind; nullopt until more bytes arrive, and always once broken.
  std::optional<IgtlMessage> next();

  bool is_broken() const { return !error_message_.empty(); }
  const std::string& error_message() const
  {
    return error_message_;
  }                                                           ///< "found ..., wanted ..."; empty while intact
  std::uint64_t n_skipped() const { return n_skipped_; }      ///< messages of other types, checksum accepted
  std::uint64_t n_malformed() const { return n_malformed_; }  ///< right checksum, but a wrong size
  std::uint64_t n_unchecked() const
  {
    return n_unchecked_;
  }  ///< checksum 0, which some senders never compute

 private:
  bool has(std::uint64_t n) const { return buffer_.size() - begin_ >= n; }
  std::span<const std::uint8_t> unparsed() const { return std::span(buffer_).subspan(begin_); }
  bool parse_header();
  bool skip_body();
  bool accepts_checksum(std::uint64_t crc);
  void set_broken(const std::string& found, const std::string& wanted);

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;                        ///< start of the unprocessed bytes
  std::optional<IgtlHeader> head_;               ///< of the message whose body is incomplete
  std::uint64_t skipped_ = 0, skipped_crc_ = 0;  ///< of a body that is being skipped
  std::uint64_t n_skipped_ = 0, n_malformed_ = 0, n_unchecked_ = 0;
  std::string error_message_;
};

}  // namespace vrda::bench
