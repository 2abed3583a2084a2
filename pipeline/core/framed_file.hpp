/// Byte format of framed_file.hpp, shared by its writer and its readers.
#pragma once

#include <Eigen/Core>

#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/fields.hpp"

namespace vrda::inline core {

struct FrameFormat {
  std::string_view magic;  ///< 8 bytes
  std::uint32_t version = 1;
  std::uint32_t longest_content = 0;  ///< bytes; a larger length means a damaged frame
  const char* frame_name = "record";  ///< in messages: "a torn record"
};

std::string header_bytes(const std::string& key, const FrameFormat& format);

/// Upper bound for all formats.
inline constexpr std::size_t longest_header_bytes = 8 + 8 + 4096 + 4;

/// Remedy for a file that cannot be resumed; only `vrda run` has the option --fresh.
inline constexpr const char* start_over_remedy =
    "the file removed to start over (vrda run --fresh, or by hand and then vrda resume)";

/// The header at the beginning of a file.
struct FrameHeader {
  std::string key;          ///< of the job that wrote it
  std::size_t n_bytes = 0;  ///< 0: invalid header; then field, found and wanted describe the error
  std::string field;
  std::string found;
  std::string wanted;
};
FrameHeader parse_header(std::string_view bytes, const FrameFormat& format);

inline constexpr std::size_t frame_head_bytes = 8;  ///< length and checksum, before the content

std::string frame_of(std::string_view content);

struct ParsedFrame {
  std::string_view content;
  std::size_t n_bytes = 0;         ///< frame and content
  std::string invalid_reason;      ///< why the frame is invalid; empty if it is valid
  std::size_t n_bytes_needed = 0;  ///< if `rest` is too short: number of bytes needed, else 0
};

/// The frame at the beginning of `rest`.
ParsedFrame parse_frame(std::string_view rest, const FrameFormat& format);

// An append-only file that survives a kill: a header (magic, format version, key, CRC-32), then frames
// (length, CRC-32 of length and content, content). All integers are little-endian.

/// Summary of such a file.
struct FrameFileSummary {
  std::string key;                  ///< of the job that wrote it
  std::uint64_t valid_bytes = 0;    ///< header and valid frames
  std::uint64_t dropped_bytes = 0;  ///< the rest
  std::string dropped_reason;       ///< empty: nothing was dropped
};

/// Calls `take` with the content of each valid frame of `bytes`, in order; it returns why the content is
/// invalid, or an empty string. A damaged or torn tail is reported, not thrown. Throws InputError with `path`
/// if the header is not that of `format`.
FrameFileSummary parse_frames(const std::string& path, std::string_view bytes, const FrameFormat& format,
                              const std::function<std::string(std::string_view)>& take);

/// The bytes of the file. Throws InputError if it cannot be read.
std::string read_frame_file(const std::string& path);
/// The same; empty if there is no file.
std::optional<std::string> read_frame_file_if_present(const std::string& path);

/// Throws InputError: another process writes the file.
[[noreturn]] void refuse_locked(const std::string& path);

/// Appends to one such file, which it locks: a second writer of the same file gets an InputError.
class FrameWriter {
 public:
  /// Creates a file with a header only, atomically, replacing an existing one.
  static FrameWriter create(const std::string& path, const std::string& key, const FrameFormat& format);

  /// Opens `path` for appending after the first `valid_bytes`; cuts off the rest.
  static FrameWriter resume(const std::string& path, std::uint64_t valid_bytes, const FrameFormat& format);

  /// create() without replacing; empty if the file exists or another process is creating it.
  static std::optional<FrameWriter> try_create(const std::string& path, const std::string& key,
                                               const FrameFormat& format);

  /// Opens `path` for appending at its end, before cut() to its valid bytes; empty if another process writes
  /// it or there is no file.
  static std::optional<FrameWriter> try_lock(const std::string& path, const FrameFormat& format);
  /// Drops everything after the first `valid_bytes`.
  void cut(std::uint64_t valid_bytes);

  ~FrameWriter();
  FrameWriter(FrameWriter&& other) noexcept;
  FrameWriter& operator=(FrameWriter&&) = delete;

  /// Writes one frame by one system call; afterwards a kill of the process cannot lose it. Synchronises with
  /// the disk if the interval of sync_every() has passed, which bounds the loss by a power cut. Thread-safe.
  /// Throws InputError if the disk is full or gone, with the earlier frames still valid; and if the file was
  /// deleted or moved, after the frame has been written.
  void append(std::string_view content);

  /// Returns when all frames are on disk, safe against a power cut. Throws like append().
  void flush();

  /// Default 5 s: fdatasync takes milliseconds, on a slow network disk tenths of a second.
  void sync_every(std::chrono::steady_clock::duration interval) { sync_interval_ = interval; }
  /// Bytes written but not yet synchronised with the disk.
  std::uint64_t n_unsynced_bytes() const { return n_bytes_ - n_synced_bytes_; }

  /// Whether the path still refers to this file, whose folder may have been deleted or moved.
  bool is_in_place() const;

  /// Creates the folder and the file again with all appended frames. Throws InputError if another file exists
  /// there, or if it cannot be written. Do not append afterwards.
  void restore() const;

  /// flush() and close the file. Do not append afterwards.
  void close();

 private:
  FrameWriter(std::string path, int descriptor, std::uint64_t n_bytes, const FrameFormat& format);

  void write(std::string_view frame);
  void sync_when_due();
  void require_in_place() const;

  std::string path_;
  FrameFormat format_;
  std::mutex mutex_;
  int descriptor_;
  bool had_name_;                              ///< false on file systems without link counts
  std::atomic<std::uint64_t> n_bytes_;         ///< header and complete frames
  std::atomic<std::uint64_t> n_synced_bytes_;  ///< those on disk
  std::chrono::steady_clock::duration sync_interval_ = std::chrono::seconds(5);
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

// Reads new frames of a file of framed_file.hpp while another process, maybe on another machine, appends.

/// Result of one poll.
struct TailUpdate {
  bool file_exists = false;
  bool is_restarted = false;        ///< the file was restarted: frames of earlier polls are obsolete
  std::vector<std::string> frames;  ///< contents of the frames since the last poll, in order
  bool has_more = false;            ///< the size limit of one poll was reached: poll again immediately
  std::string invalid_reason;       ///< error after the last valid frame; it may be gone at the next poll
  std::int64_t changed_ns = 0;      ///< modification time of the file
};

/// Reads each complete frame once. Does not lock, write or throw for errors of the file, since an absent,
/// torn or damaged file may be valid at the next poll. Every poll opens the file again, since it may have
/// been replaced and network file systems update its size at open.
class FrameTail {
 public:
  FrameTail(std::string path, const FrameFormat& format) : path_(std::move(path)), format_(format) {}

  TailUpdate poll();

  const std::string& path() const { return path_; }
  const std::string& key() const { return key_; }  ///< of the job that wrote it; empty if not read yet

 private:
  struct Identity {
    std::uint64_t device = 0, inode = 0;
    bool operator==(const Identity&) const = default;
  };
  bool is_continued(int descriptor, std::string_view header, std::uint64_t n_bytes) const;
  void take_frames(int descriptor, std::uint64_t n_bytes, TailUpdate& news);

  std::string path_;
  FrameFormat format_;
  std::string key_;
  Identity identity_;
  bool was_there_ = false;        // at the last poll
  std::string header_;            // empty: none read yet
  std::uint64_t n_read_ = 0;      // bytes of header and frames read
  std::uint64_t last_frame_ = 0;  // offset of the last frame read
  std::string last_head_;         // its length and checksum
};

// Numbers as little-endian bytes; doubles as their 64 bits.

void append_u32(std::string& bytes, std::uint32_t value);
void append_i8(std::string& bytes, std::int8_t value);
void append_i32(std::string& bytes, std::int32_t value);
void append_double(std::string& bytes, double value);
void append_vector(std::string& bytes, const Eigen::Vector3d& v);

std::uint32_t u32_at(std::string_view bytes, std::size_t offset);

/// Reads values sequentially; past the end it returns zeros and becomes invalid.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  std::size_t n_bytes_left() const { return bytes_.size() - at_; }
  bool is_valid() const { return is_sound_; }
  /// Marks the bytes as invalid, for a value out of range.
  void mark_invalid() { is_sound_ = false; }

  /// An integer of at most 8 bytes.
  std::uint64_t take(std::size_t n_bytes)
  {
    if (n_bytes_left() < n_bytes) {
      is_sound_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n_bytes; ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[at_ + i])} << (8 * i);
    }
    at_ += n_bytes;
    return value;
  }
  std::int8_t take_i8() { return static_cast<std::int8_t>(take(1)); }
  std::int32_t take_i32() { return static_cast<std::int32_t>(take(4)); }
  double take_double() { return std::bit_cast<double>(take(8)); }
  bool take_bool()
  {
    const std::uint64_t value = take(1);
    if (value > 1) is_sound_ = false;
    return value == 1;
  }
  Eigen::Vector3d take_vector()
  {
    Eigen::Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = take_double();
    return v;
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool is_sound_ = true;
};

/// Appends a value: numbers as above, flags and enums as one byte, a list after the number of its elements
/// (u32), an optional value after a flag, a struct field by field (fields.hpp).
template <typename Value>
void append_value(std::string& bytes, const Value& value)
{
  if constexpr (Described<Value>) {
    for_each_field(value, [&](const auto&, const auto& member) { append_value(bytes, member); });
  } else if constexpr (std::is_same_v<Value, double>) {
    append_double(bytes, value);
  } else if constexpr (sizeof(Value) == 1) {
    append_i8(bytes, static_cast<std::int8_t>(value));
  } else if constexpr (std::is_same_v<Value, std::int32_t>) {
    append_i32(bytes, value);
  } else if constexpr (requires { value.has_value(); }) {
    append_value(bytes, value.has_value());
    if (value) append_value(bytes, *value);
  } else {
    if constexpr (requires(Value list) { list.emplace_back(); })
      append_u32(bytes, static_cast<std::uint32_t>(value.size()));
    for (const auto& element : value) append_value(bytes, element);
  }
}

/// The inverse of append_value(). Bytes that end early, an enum's unknown value, a flag other than 0 and 1,
/// and a struct for which its `is_sound(value)` is false make the reader invalid.
template <typename Value>
void take_value(ByteReader& reader, Value& value)
{
  if constexpr (Described<Value>) {
    for_each_field(value, [&](const auto&, auto& member) { take_value(reader, member); });
    if constexpr (requires { is_sound(value); })
      if (!is_sound(value)) reader.mark_invalid();
  } else if constexpr (std::is_same_v<Value, double>) {
    value = reader.take_double();
  } else if constexpr (std::is_same_v<Value, bool>) {
    value = reader.take_bool();
  } else if constexpr (Listed<Value>) {
    value = static_cast<Value>(reader.take_i8());
    if (!is_listed(value)) reader.mark_invalid();
  } else if constexpr (std::is_same_v<Value, std::int8_t>) {
    value = reader.take_i8();
  } else if constexpr (std::is_same_v<Value, std::int32_t>) {
    value = reader.take_i32();
  } else if constexpr (requires { value.emplace(); }) {
    value.reset();
    if (reader.take_bool()) take_value(reader, value.emplace());
  } else if constexpr (requires { value.emplace_back(); }) {
    // Grows with the bytes that are there, whatever the number says.
    const std::uint64_t n = reader.take(4);
    for (std::uint64_t k = 0; k < n && reader.is_valid(); ++k) take_value(reader, value.emplace_back());
  } else {
    for (auto& element : value) take_value(reader, element);
  }
}

/// The bytes of one struct.
template <Described Value>
std::string bytes_of_value(const Value& value)
{
  std::string bytes;
  append_value(bytes, value);
  return bytes;
}

/// The inverse of bytes_of_value(); empty unless all bytes are one valid value.
template <Described Value>
std::optional<Value> value_of_bytes(std::string_view bytes)
{
  ByteReader reader(bytes);
  Value value;
  take_value(reader, value);
  return reader.is_valid() && reader.n_bytes_left() == 0 ? std::optional(std::move(value)) : std::nullopt;
}

}  // namespace vrda::inline core
