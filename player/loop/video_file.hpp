/// A film written by ffmpeg, which is a program of its own and need not be there.
#pragma once

#include <sys/types.h>

#include <string>

#include "render/image.hpp"

namespace vrda {

struct VideoOptions {
  std::string path;  ///< .mp4, .webm or .gif, which says how it is coded
  int width = 0, height = 0;
  int frames_per_s = 25;
};

/// Throws InputError for an ending that is not known.
void require_video_name(const std::string& path);

/// Frames go to ffmpeg as they come, through a socket; what it writes gets its name when it is whole.
/// Throws InputError when there is no ffmpeg, when it fails (with its own words), or for an ending that is
/// not known.
class VideoFile {
 public:
  explicit VideoFile(const VideoOptions& options);
  /// Without `finish` nothing is left of the file.
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// Of the size in the options.
  void add(const Image& image);
  void finish();

 private:
  void start();
  void stop();
  [[noreturn]] void fail(int status);
  int ended();

  VideoOptions options_;
  std::string unfinished_path_;
  pid_t ffmpeg_ = -1;
  int frames_ = -1;    ///< our end of the socket
  int messages_ = -1;  ///< what ffmpeg says, in memory
};

}  // namespace vrda
