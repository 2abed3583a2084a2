/// An append-only file that a kill cannot damage: a header (magic, format version, key, CRC-32), then frames:
/// length, CRC-32 of length and content, content. All integers little-endian.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "journal/frame_bytes.hpp"

namespace vrda {

/// What stands in such a file besides the contents of its frames.
struct FrameFacts {
  std::string key;                  ///< of the job that wrote it
  std::uint64_t valid_bytes = 0;    ///< header and whole frames
  std::uint64_t dropped_bytes = 0;  ///< what follows them
  std::string dropped_why;          ///< empty: nothing was dropped
};

/// Shows `take` the content of each whole frame of `bytes`, in order; it says what the content is instead of
/// what was wanted, or nothing when it is right. A damaged or torn tail is reported, not thrown. Throws
/// InputError naming `path` when the header is not that of `format`.
FrameFacts parse_frames(const std::string& path, std::string_view bytes, const FrameFormat& format,
                        const std::function<std::string(std::string_view)>& take);

/// The whole file. Throws InputError naming it when it cannot be read.
std::string frame_bytes_of(const std::string& path);
/// The same; nothing where there is no file.
std::optional<std::string> frame_bytes_if_there(const std::string& path);

/// Appends to one such file. It is locked: a second writer of the same file gets an InputError.
class FrameWriter {
 public:
  /// Starts an empty file, replacing what is there; the header appears whole or not at all.
  static FrameWriter create(const std::string& path, const std::string& key, const FrameFormat& format);

  /// Goes on after the first `valid_bytes` of `path`; cuts the rest off.
  static FrameWriter resume(const std::string& path, std::uint64_t valid_bytes, const FrameFormat& format);

  /// create() of a file that is not there yet; nothing when it is, or while another process creates it.
  static std::optional<FrameWriter> try_create(const std::string& path, const std::string& key,
                                               const FrameFormat& format);

  /// Goes on at the end of `path`, for cut() once its bytes are looked at; nothing while another process
  /// writes it, or where there is no file.
  static std::optional<FrameWriter> try_lock(const std::string& path, const FrameFormat& format);
  /// Drops what follows the first `valid_bytes`.
  void cut(std::uint64_t valid_bytes);

  ~FrameWriter();
  FrameWriter(FrameWriter&& other) noexcept;
  FrameWriter& operator=(FrameWriter&&) = delete;

  /// Hands one frame to the system in one write; from then on a kill of the process cannot lose it. Waits
  /// for the disk when the last wait is sync_every() ago, so that a power cut loses no more than that.
  /// Any thread may call. Throws InputError when the disk is full or gone; what was written stays valid.
  /// Throws one too when the file was deleted or moved meanwhile; the frame is in it even then.
  void append(std::string_view content);

  /// Waits until everything has reached the disk, so that a power cut cannot lose it. Throws like append().
  void flush();

  /// 5 s unless told: an fdatasync takes milliseconds, on a slow network disk tenths of a second.
  void sync_every(std::chrono::steady_clock::duration interval) { sync_interval_ = interval; }
  /// Bytes that append() has not waited for.
  std::uint64_t n_unsynced_bytes() const { return n_bytes_ - n_synced_bytes_; }

  /// Whether the path still leads to this file: an open file lives on when its folder is deleted or moved.
  bool is_in_place() const;

  /// Makes the folder and the file anew with all that was appended. Throws InputError when another file
  /// stands there, or when it cannot be written. Nothing may be appended afterwards.
  void restore() const;

  /// flush() and let go of the file. Nothing may be appended afterwards.
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
  bool had_name_;                              ///< some file systems count no names of a file
  std::atomic<std::uint64_t> n_bytes_;         ///< header and whole frames
  std::atomic<std::uint64_t> n_synced_bytes_;  ///< of them on the disk
  std::chrono::steady_clock::duration sync_interval_ = std::chrono::seconds(5);
  std::chrono::steady_clock::time_point synced_ = std::chrono::steady_clock::now();
};

}  // namespace vrda
