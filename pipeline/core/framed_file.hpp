/// An append-only file that survives a kill: a header (magic, format version, key, CRC-32), then frames
/// (length, CRC-32 of length and content, content). All integers are little-endian.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "core/frame_bytes.hpp"

namespace vrda::inline core {

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

}  // namespace vrda::inline core
