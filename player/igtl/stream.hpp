/// OpenIGTLink messages out of the bytes of a connection, however they are cut.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "igtl/message.hpp"

namespace vrda {

/// The protocol has no mark where a message starts: after a header that cannot be one, or a wrong checksum,
/// nothing that follows can be trusted. The stream is broken then, and the connection is to be made anew.
class IgtlStream {
 public:
  /// Most bytes of a body that is kept: 900 tools of TDATA. What is asked for less is not allocated.
  static constexpr std::uint64_t most_body_bytes = 64 * 1024;
  /// Most bytes of a body that is skipped (images): more is taken for garbage.
  static constexpr std::uint64_t most_skipped_bytes = 1ULL << 32;

  void add(std::span<const std::uint8_t> bytes);

  /// The next whole message of a known kind; nothing until more bytes come, and for ever once broken.
  std::optional<IgtlMessage> next();

  bool is_broken() const { return !trouble_.empty(); }
  const std::string& trouble() const { return trouble_; }     ///< "found ..., wanted ..."; empty while whole
  std::uint64_t n_skipped() const { return n_skipped_; }      ///< messages of other types, checksum right
  std::uint64_t n_malformed() const { return n_malformed_; }  ///< checksum right, content of a wrong size

 private:
  bool has(std::uint64_t n) const { return buffer_.size() - begin_ >= n; }
  std::span<const std::uint8_t> waiting() const { return std::span(buffer_).subspan(begin_); }
  bool take_head();
  bool skip_body();
  void break_off(const std::string& found, const std::string& wanted);

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;                        ///< of what is not used yet
  std::optional<IgtlHead> head_;                 ///< of the message whose body is awaited
  std::uint64_t skipped_ = 0, skipped_crc_ = 0;  ///< of a body that is passed over
  std::uint64_t n_skipped_ = 0, n_malformed_ = 0;
  std::string trouble_;
};

}  // namespace vrda
