/// Looks on while another process, maybe on another machine, appends to a file of framed_file.hpp.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "journal/frame_bytes.hpp"

namespace vrda {

/// What one look at the file found.
struct TailNews {
  bool is_there = false;
  bool is_anew = false;             ///< begun anew: contents of earlier looks count no more
  std::vector<std::string> frames;  ///< contents of the frames that came since the last look, in order
  bool has_more = false;            ///< as many as one look takes: look again at once
  std::string why_not;          ///< what stands behind the last whole frame; it may be whole at the next look
  std::int64_t changed_ns = 0;  ///< when the file was last changed, by the clock of its disk
};

/// Reads each whole frame once. Never locks, never writes and throws nothing about the file: it may be
/// absent, torn or damaged today and whole tomorrow. Every look opens the file anew: it may have been
/// replaced, and a network disk tells its size only then.
class FrameTail {
 public:
  FrameTail(std::string path, const FrameFormat& format) : path_(std::move(path)), format_(format) {}

  TailNews look();

  const std::string& path() const { return path_; }
  const std::string& key() const { return key_; }  ///< of the job that wrote it; empty until it was seen

 private:
  struct Identity {
    std::uint64_t device = 0, inode = 0;
    bool operator==(const Identity&) const = default;
  };
  bool is_continued(int descriptor, std::string_view header, std::uint64_t n_bytes) const;
  void take_frames(int descriptor, std::uint64_t n_bytes, TailNews& news);

  std::string path_;
  FrameFormat format_;
  std::string key_;
  Identity identity_;
  bool was_there_ = false;        // at the last look
  std::string header_;            // empty: none seen yet
  std::uint64_t taken_ = 0;       // bytes of header and frames taken
  std::uint64_t last_frame_ = 0;  // where the last one begins, and its length and checksum
  std::string last_head_;
};

}  // namespace vrda
