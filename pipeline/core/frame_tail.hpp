/// Reads new frames of a file of framed_file.hpp while another process, maybe on another machine, appends.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame_bytes.hpp"

namespace vrda::inline core {

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

}  // namespace vrda::inline core
