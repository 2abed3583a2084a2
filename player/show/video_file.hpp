/// A video file encoded by the external program ffmpeg, which is optional.
#pragma once

#include <sys/types.h>

#include <string>

#include "core/publication.hpp"
#include "view/image.hpp"

namespace vrda::show {

struct VideoOptions {
  std::string path;  ///< .mp4, .webm or .gif; the suffix selects the encoding
  int width = 0, height = 0;
  int frames_per_s = 25;
};

/// Throws InputError for an unknown suffix.
void require_video_name(const std::string& path);

/// Sends frames to ffmpeg through a socket; the output is published as `path` when complete. Throws
/// InputError for an unknown suffix, if another process writes the video, if ffmpeg is not installed, or if
/// it fails (with its error output).
class VideoFile {
 public:
  explicit VideoFile(const VideoOptions& options);
  /// Without `finish`, deletes the incomplete file.
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// Adds a frame of the size in the options.
  void add(const view::Image& image);
  void finish();

 private:
  void start();
  void stop();
  [[noreturn]] void fail(int status);
  int wait_for_ffmpeg();

  VideoOptions options_;
  std::string unfinished_path_;  ///< beside the target of a link
  Publication publication_;
  pid_t ffmpeg_ = -1;
  int frames_ = -1;    ///< local end of the socket
  int messages_ = -1;  ///< ffmpeg's output, a file in memory
};

}  // namespace vrda::show
