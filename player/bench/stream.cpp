#include "bench/stream.hpp"

#include <algorithm>

namespace vrda::bench {

void IgtlStream::set_broken(const std::string& found, const std::string& wanted)
{
  error_message_ = "found " + found + ", wanted " + wanted;
  buffer_.clear();
  begin_ = 0;
}

void IgtlStream::add(std::span<const std::uint8_t> bytes)
{
  if (is_broken()) return;
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

/// False where the stream is broken.
bool IgtlStream::parse_header()
{
  IgtlHeader head = header_of(unparsed().first(igtl_header_bytes));
  if (head.version != 1 && head.version != 2) {
    set_broken("header version " + std::to_string(head.version), "1 or 2 of OpenIGTLink");
  } else if (head.type.empty() || head.type.find('?') != std::string::npos) {
    set_broken("type '" + head.type + "'", "the name of an OpenIGTLink message");
  } else if (const std::uint64_t most = is_known_type(head.type) ? max_body_bytes : max_skipped_bytes;
             head.body_bytes > most) {
    set_broken(head.type + " of " + std::to_string(head.body_bytes) + " bytes",
               "at most " + std::to_string(most));
  }
  if (is_broken()) return false;
  begin_ += igtl_header_bytes;
  skipped_ = skipped_crc_ = 0;
  head_ = std::move(head);
  return true;
}

/// Of the complete body. Some senders write 0 instead of a checksum: their messages are counted.
bool IgtlStream::accepts_checksum(std::uint64_t crc)
{
  if (crc == head_->crc) return true;
  if (head_->crc == 0) {
    ++n_unchecked_;
    return true;
  }
  set_broken(head_->type + " with a wrong checksum", "CRC64 of its body");
  return false;
}

/// Skips the available part of the body; true when it is complete and its checksum is accepted.
bool IgtlStream::skip_body()
{
  const std::uint64_t n = std::min<std::uint64_t>(head_->body_bytes - skipped_, unparsed().size());
  skipped_crc_ = igtl_crc(unparsed().first(n), skipped_crc_);
  skipped_ += n;
  begin_ += n;
  if (skipped_ < head_->body_bytes) return false;
  if (!accepts_checksum(skipped_crc_)) return false;
  ++n_skipped_;
  head_.reset();
  return true;
}

std::optional<IgtlMessage> IgtlStream::next()
{
  while (!is_broken()) {
    if (!head_ && (!has(igtl_header_bytes) || !parse_header())) return std::nullopt;
    if (!is_known_type(head_->type)) {
      if (!skip_body()) return std::nullopt;
      continue;
    }
    if (!has(head_->body_bytes)) return std::nullopt;
    const std::span<const std::uint8_t> body = unparsed().first(head_->body_bytes);
    if (!accepts_checksum(igtl_crc(body))) return std::nullopt;
    std::optional<IgtlMessage> message = message_of(*head_, body);
    begin_ += body.size();
    head_.reset();
    if (message) return message;
    ++n_malformed_;
  }
  return std::nullopt;
}

}  // namespace vrda::bench
