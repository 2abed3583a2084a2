#include "core/frame_tail.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "core/open_file.hpp"

namespace vrda::inline core {
namespace {

/// Size limit of one poll, unless a single frame is longer: some thousand steps, so that a poll returns
/// quickly.
constexpr std::uint64_t bytes_per_poll = std::uint64_t{1} << 22;

/// Bytes of the file from `offset`: fewer than `n_bytes` if it ends or cannot be read.
std::string bytes_at(int descriptor, std::uint64_t offset, std::uint64_t n_bytes)
{
  std::string bytes(n_bytes, '\0');
  std::size_t n_read = 0;
  while (n_read < n_bytes) {
    const ssize_t n =
        pread(descriptor, bytes.data() + n_read, n_bytes - n_read, static_cast<off_t>(offset + n_read));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    n_read += static_cast<std::size_t>(n);
  }
  bytes.resize(n_read);
  return bytes;
}

std::int64_t changed_ns(const struct stat& facts)
{
  return std::int64_t{facts.st_mtim.tv_sec} * 1'000'000'000 + facts.st_mtim.tv_nsec;
}

}  // namespace

TailUpdate FrameTail::poll()
{
  TailUpdate news;
  const OpenFile descriptor(open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat facts {};
  const bool is_file =
      descriptor.get() >= 0 && fstat(descriptor.get(), &facts) == 0 && S_ISREG(facts.st_mode);
  // The inode of a deleted file may be reused by the next one.
  const Identity identity{facts.st_dev, facts.st_ino};
  const bool is_same_file = was_there_ && is_file && identity == identity_;
  was_there_ = is_file;
  if (!is_file) return news;
  identity_ = identity;
  news.file_exists = true;
  news.changed_ns = changed_ns(facts);

  const auto n_bytes = static_cast<std::uint64_t>(facts.st_size);
  const std::string head =
      bytes_at(descriptor.get(), 0, std::min<std::uint64_t>(n_bytes, longest_header_bytes));
  const FrameHeader header = parse_header(head, format_);
  if (header.n_bytes == 0) {
    news.invalid_reason = header.found;
    return news;
  }
  const std::string_view found_header = std::string_view(head).substr(0, header.n_bytes);
  if (!is_same_file || !is_continued(descriptor.get(), found_header, n_bytes)) {
    news.is_restarted = !header_.empty();
    header_ = found_header;
    key_ = header.key;
    n_read_ = header_.size();
    last_head_.clear();
  }
  take_frames(descriptor.get(), n_bytes, news);
  return news;
}

// A file that was cut and written again may be as long as before: compares the last frame read.
bool FrameTail::is_continued(int descriptor, std::string_view header, std::uint64_t n_bytes) const
{
  if (header != header_ || n_bytes < n_read_) return false;
  return last_head_.empty() || bytes_at(descriptor, last_frame_, frame_head_bytes) == last_head_;
}

void FrameTail::take_frames(int descriptor, std::uint64_t n_bytes, TailUpdate& news)
{
  std::string bytes = bytes_at(descriptor, n_read_, std::min(n_bytes - n_read_, bytes_per_poll));
  const ParsedFrame first = parse_frame(bytes, format_);
  if (first.n_bytes_needed > bytes.size() && first.n_bytes_needed <= n_bytes - n_read_) {
    bytes = bytes_at(descriptor, n_read_, first.n_bytes_needed);
  }
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const ParsedFrame taken = parse_frame(rest, format_);
    if (!taken.invalid_reason.empty()) {
      news.has_more = taken.n_bytes_needed > 0 && n_read_ + taken.n_bytes_needed <= n_bytes;
      if (!news.has_more) news.invalid_reason = taken.invalid_reason;
      return;
    }
    news.frames.emplace_back(taken.content);
    last_frame_ = n_read_;
    last_head_ = rest.substr(0, frame_head_bytes);
    n_read_ += taken.n_bytes;
    rest.remove_prefix(taken.n_bytes);
  }
  news.has_more = n_read_ < n_bytes;
}

}  // namespace vrda::inline core
