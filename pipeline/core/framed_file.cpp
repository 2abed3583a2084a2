#include "core/framed_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/files.hpp"
#include "core/text.hpp"

namespace vrda::inline core {
namespace {

/// A key has 64 digits; a much larger length means a damaged header.
constexpr std::uint32_t longest_key = 4096;

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0)
{
  const uLong crc = crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  return static_cast<std::uint32_t>(crc);
}

}  // namespace

std::string header_bytes(const std::string& key, const FrameFormat& format)
{
  std::string bytes(format.magic);
  append_u32(bytes, format.version);
  append_u32(bytes, static_cast<std::uint32_t>(key.size()));
  bytes += key;
  append_u32(bytes, crc_of(bytes));
  return bytes;
}

FrameHeader parse_header(std::string_view bytes, const FrameFormat& format)
{
  const std::size_t fixed = format.magic.size() + 8;
  if (bytes.substr(0, format.magic.size()) != format.magic || bytes.size() < fixed) {
    return {"", 0, "header", "not a journal (" + std::to_string(bytes.size()) + " bytes)",
            "a journal of vrda"};
  }
  const std::uint32_t found_version = u32_at(bytes, format.magic.size());
  const std::uint32_t key_bytes = u32_at(bytes, format.magic.size() + 4);
  const bool is_whole = key_bytes <= longest_key && bytes.size() >= fixed + key_bytes + 4;
  const std::size_t end = is_whole ? fixed + key_bytes : 0;
  if (!is_whole || u32_at(bytes, end) != crc_of(bytes.substr(0, end))) {
    return {"", 0, "header", "a damaged header", std::string("an intact header, or ") + start_over_remedy};
  }
  if (found_version != format.version) {
    return {"", 0, "format version", std::to_string(found_version),
            std::to_string(format.version) + ", or " + start_over_remedy};
  }
  return {std::string(bytes.substr(fixed, key_bytes)), end + 4, "", "", ""};
}

std::string frame_of(std::string_view content)
{
  std::string bytes;
  bytes.reserve(frame_head_bytes + content.size());
  append_u32(bytes, static_cast<std::uint32_t>(content.size()));
  append_u32(bytes, crc_of(content, crc_of(bytes)));
  return bytes.append(content);
}

ParsedFrame parse_frame(std::string_view rest, const FrameFormat& format)
{
  const std::string name = format.frame_name;
  if (rest.size() < frame_head_bytes) return {{}, 0, "a torn frame", frame_head_bytes};
  const std::uint32_t length = u32_at(rest, 0);
  if (length > format.longest_content) return {{}, 0, "a frame of " + std::to_string(length) + " bytes", 0};
  if (rest.size() - frame_head_bytes < length) return {{}, 0, "a torn " + name, frame_head_bytes + length};
  const std::string_view content = rest.substr(frame_head_bytes, length);
  if (crc_of(content, crc_of(rest.substr(0, 4))) != u32_at(rest, 4)) {
    return {{}, 0, "a " + name + " with a wrong checksum", 0};
  }
  return {content, frame_head_bytes + length, {}, 0};
}

namespace {

constexpr const char* wanted_readable = "a journal that can be read";
constexpr const char* wanted_writable = "a journal that can be written and free space";

[[noreturn]] void fail(const std::string& path, const std::string& what, const char* wanted)
{
  throw InputError({path, "", what + " (" + std::strerror(errno) + ")", wanted});
}

/// The process of this machine that holds the file's lock, as in " (process 12)"; empty if unknown.
std::string lock_holder(const std::string& path)
{
  struct stat facts {};
  if (stat(path.c_str(), &facts) != 0) return "";
  const std::string inode = ":" + std::to_string(facts.st_ino);
  // "1: FLOCK ADVISORY WRITE 12 fe:00:345 0 EOF"; a process of another container is 0.
  std::ifstream locks("/proc/locks");
  std::string number, kind, mode, access, process, file, rest;
  while (locks >> number >> kind >> mode >> access >> process >> file && std::getline(locks, rest)) {
    if (kind == "FLOCK" && file.ends_with(inode) && process != "0") return " (process " + process + ")";
  }
  return "";
}

/// Link count of the file; 0 if it was deleted.
nlink_t n_links_of(int descriptor)
{
  struct stat facts {};
  return fstat(descriptor, &facts) == 0 ? facts.st_nlink : 0;
}

enum class Creation { replace, only_new };

/// Removes an empty temporary file unless it is kept: on a file system without locks no process writes it.
struct RemovedWhileEmpty {
  int descriptor;
  const std::string& name;
  bool is_kept = false;

  ~RemovedWhileEmpty()
  {
    struct stat facts {};
    if (!is_kept && fstat(descriptor, &facts) == 0 && facts.st_size == 0) std::remove(name.c_str());
  }
};

/// Locks the temporary file; removes it on a file system without locks, which throws.
bool is_locked_by_us(int descriptor, const std::string& temporary, const std::string& path)
{
  RemovedWhileEmpty opened{descriptor, temporary};
  const bool is_locked = try_lock_file(descriptor, path);
  opened.is_kept = true;
  return is_locked;
}

/// Creates `path` with `bytes` atomically, by a temporary file and a rename. Returns the open and locked
/// file; empty if another process does the same, or if `only_new` finds an existing file.
std::optional<int> try_write_new(const std::string& path, const std::string& bytes, Creation creation)
{
  const std::string temporary = path + ".partial";
  // Not truncated at open: it may belong to another process until it is locked.
  OpenFile descriptor(open(temporary.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (descriptor.get() < 0) fail(path, "a journal that cannot be created", wanted_writable);
  if (!is_locked_by_us(descriptor.get(), temporary, path) || !is_open_file_at(descriptor.get(), temporary)) {
    return std::nullopt;
  }
  // Checked under the lock of the temporary file, which excludes other creators; the lock of the old file
  // excludes processes that resume it.
  const OpenFile old(open(path.c_str(), O_RDWR | O_CLOEXEC));
  const bool is_taken = creation == Creation::only_new ? access(path.c_str(), F_OK) == 0
                                                       : old.get() >= 0 && !try_lock_file(old.get(), path);
  if (is_taken) {
    std::remove(temporary.c_str());
    return std::nullopt;
  }
  const bool is_written = ftruncate(descriptor.get(), 0) == 0 && write_all(descriptor.get(), bytes) &&
                          fsync(descriptor.get()) == 0 && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (!is_written) {
    const int kept = errno;
    std::remove(temporary.c_str());
    errno = kept;
    fail(path, "a journal that cannot be created", wanted_writable);
  }
  sync_parent_directory(path);
  return descriptor.release();
}

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

}  // namespace

void refuse_locked(const std::string& path)
{
  throw InputError({path, "", "a journal that another run" + lock_holder(path) + " is writing",
                    "no other run with the same output"});
}

std::string read_frame_file(const std::string& path)
{
  std::optional<std::string> bytes = read_frame_file_if_present(path);
  if (bytes) return std::move(*bytes);
  errno = ENOENT;
  fail(path, "no access", wanted_readable);
}

std::optional<std::string> read_frame_file_if_present(const std::string& path)
{
  const OpenFile descriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.get() < 0 && errno == ENOENT) return std::nullopt;
  if (descriptor.get() < 0) fail(path, "no access", wanted_readable);
  std::string bytes;
  std::string block(std::size_t{1} << 16, '\0');
  for (;;) {
    const ssize_t n = ::read(descriptor.get(), block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "a read error", wanted_readable);
    if (n == 0) return bytes;
    bytes.append(block, 0, static_cast<std::size_t>(n));
  }
}

FrameFileSummary parse_frames(const std::string& path, std::string_view bytes, const FrameFormat& format,
                              const std::function<std::string(std::string_view)>& take)
{
  FrameFileSummary facts;
  const FrameHeader header = parse_header(bytes, format);
  if (header.n_bytes == 0) throw InputError({path, header.field, header.found, header.wanted});
  facts.key = header.key;
  std::size_t offset = header.n_bytes;
  while (offset < bytes.size()) {
    const ParsedFrame taken = parse_frame(bytes.substr(offset), format);
    facts.dropped_reason = taken.invalid_reason.empty() ? take(taken.content) : taken.invalid_reason;
    if (!facts.dropped_reason.empty()) break;
    offset += taken.n_bytes;
  }
  facts.valid_bytes = offset;
  facts.dropped_bytes = bytes.size() - offset;
  return facts;
}

FrameWriter FrameWriter::create(const std::string& path, const std::string& key, const FrameFormat& format)
{
  const std::string header = header_bytes(key, format);
  const std::optional<int> descriptor = try_write_new(path, header, Creation::replace);
  if (!descriptor) refuse_locked(path);
  return FrameWriter(path, *descriptor, header.size(), format);
}

std::optional<FrameWriter> FrameWriter::try_create(const std::string& path, const std::string& key,
                                                   const FrameFormat& format)
{
  const std::string header = header_bytes(key, format);
  const std::optional<int> descriptor = try_write_new(path, header, Creation::only_new);
  if (!descriptor) return std::nullopt;
  return FrameWriter(path, *descriptor, header.size(), format);
}

std::optional<FrameWriter> FrameWriter::try_lock(const std::string& path, const FrameFormat& format)
{
  OpenFile descriptor(open(path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC));
  if (descriptor.get() < 0 && errno == ENOENT) return std::nullopt;
  if (descriptor.get() < 0) fail(path, "a journal that cannot be opened", wanted_writable);
  struct stat facts {};
  if (!try_lock_file(descriptor.get(), path) || !is_open_file_at(descriptor.get(), path) ||
      fstat(descriptor.get(), &facts) != 0) {
    return std::nullopt;
  }
  return FrameWriter(path, descriptor.release(), static_cast<std::uint64_t>(facts.st_size), format);
}

FrameWriter FrameWriter::resume(const std::string& path, std::uint64_t valid_bytes, const FrameFormat& format)
{
  std::optional<FrameWriter> writer = try_lock(path, format);
  if (!writer) refuse_locked(path);
  writer->cut(valid_bytes);
  return std::move(*writer);
}

void FrameWriter::cut(std::uint64_t valid_bytes)
{
  const std::lock_guard<std::mutex> guard(mutex_);
  if (ftruncate(descriptor_, static_cast<off_t>(valid_bytes)) != 0) {
    fail(path_, "a journal that cannot be cut", wanted_writable);
  }
  n_bytes_ = valid_bytes;
  n_synced_bytes_ = valid_bytes;
}

FrameWriter::~FrameWriter()
{
  if (descriptor_ >= 0) ::close(descriptor_);
}

FrameWriter::FrameWriter(std::string path, int descriptor, std::uint64_t n_bytes, const FrameFormat& format)
    : path_(std::move(path)),
      format_(format),
      descriptor_(descriptor),
      had_name_(n_links_of(descriptor) > 0),
      n_bytes_(n_bytes),
      n_synced_bytes_(n_bytes)
{
}

FrameWriter::FrameWriter(FrameWriter&& other) noexcept
    : path_(std::move(other.path_)),
      format_(other.format_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      had_name_(other.had_name_),
      n_bytes_(other.n_bytes_.load()),
      n_synced_bytes_(other.n_synced_bytes_.load()),
      sync_interval_(other.sync_interval_),
      synced_(other.synced_)
{
}

void FrameWriter::append(std::string_view content)
{
  check(content.size() <= format_.longest_content, "journal: the content fits a frame");
  write(frame_of(content));
  require_in_place();
  sync_when_due();
}

void FrameWriter::write(std::string_view frame)
{
  const std::lock_guard<std::mutex> guard(mutex_);
  check(descriptor_ >= 0, "journal: write to a closed file");
  if (write_all(descriptor_, frame)) {
    n_bytes_ += frame.size();
    return;
  }
  const int kept = errno;
  // Truncates a torn frame, so that a later append does not follow it. Otherwise the reader drops the tail.
  const int cut = ftruncate(descriptor_, static_cast<off_t>(n_bytes_));
  static_cast<void>(cut);
  errno = kept;
  fail(path_, "a " + std::string(format_.frame_name) + " that cannot be written", wanted_writable);
}

void FrameWriter::sync_when_due()
{
  {
    const std::lock_guard<std::mutex> guard(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < sync_interval_) return;
    synced_ = now;
  }
  // Without the lock, so that other threads can append meanwhile.
  const std::uint64_t n_bytes = n_bytes_;
  if (fdatasync(descriptor_) != 0) fail(path_, "a journal that cannot be flushed", wanted_writable);
  n_synced_bytes_ = n_bytes;
}

void FrameWriter::flush()
{
  const std::lock_guard<std::mutex> guard(mutex_);
  check(descriptor_ >= 0, "journal: flush of a closed file");
  if (fsync(descriptor_) != 0) fail(path_, "a journal that cannot be flushed", wanted_writable);
  n_synced_bytes_ = n_bytes_.load();
  require_in_place();
}

bool FrameWriter::is_in_place() const
{
  struct stat at_path {};
  const bool is_there = stat(path_.c_str(), &at_path) == 0 || (errno != ENOENT && errno != ENOTDIR);
  return is_there && (!had_name_ || n_links_of(descriptor_) > 0);
}

void FrameWriter::require_in_place() const
{
  if (is_in_place()) return;
  throw InputError(
      {path_, "", "a journal that was deleted or moved while it was written", "an unchanged path"});
}

void FrameWriter::restore() const
{
  const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (access(path_.c_str(), F_OK) == 0) {
    throw InputError(
        {path_, "", "another file in place of the journal", "no other run with the same output"});
  }
  const std::string bytes = bytes_at(descriptor_, 0, n_bytes_);
  if (bytes.size() < n_bytes_) fail(path_, "a journal that cannot be read back", wanted_writable);
  const std::optional<int> written = try_write_new(path_, bytes, Creation::only_new);
  if (!written) refuse_locked(path_);
  const OpenFile closed(*written);
}

void FrameWriter::close()
{
  flush();
  const std::lock_guard<std::mutex> guard(mutex_);
  if (::close(std::exchange(descriptor_, -1)) != 0)
    fail(path_, "a journal that cannot be closed", wanted_writable);
}

namespace {

/// Size limit of one poll, unless a single frame is longer: some thousand steps, so that a poll returns
/// quickly.
constexpr std::uint64_t bytes_per_poll = std::uint64_t{1} << 22;

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

namespace {

void append_u64(std::string& bytes, std::uint64_t value)
{
  for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
}

}  // namespace

void append_u32(std::string& bytes, std::uint32_t value)
{
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
}

void append_i8(std::string& bytes, std::int8_t value)
{
  bytes.push_back(static_cast<char>(value));
}

void append_i32(std::string& bytes, std::int32_t value)
{
  append_u32(bytes, static_cast<std::uint32_t>(value));
}

void append_double(std::string& bytes, double value)
{
  append_u64(bytes, std::bit_cast<std::uint64_t>(value));
}

void append_vector(std::string& bytes, const Eigen::Vector3d& v)
{
  for (int i = 0; i < 3; ++i) append_double(bytes, v[i]);
}

std::uint32_t u32_at(std::string_view bytes, std::size_t offset)
{
  return static_cast<std::uint32_t>(ByteReader(bytes.substr(offset)).take(4));
}

}  // namespace vrda::inline core
