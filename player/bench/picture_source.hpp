/// Pictures of a camera, or of a film or a numbered sequence of files in its place.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "bench/camera.hpp"

namespace vrda::bench {

struct PictureSourceOptions {
  std::string device = "/dev/video0";  ///< or a film, or "folder/picture_%03d.png"; these repeat
  int width = 640, height = 480;       ///< requested from a camera
  double rate_hz = 30.0;
};

struct TimedPicture {
  GreyPicture picture;
  std::int64_t taken_ns = 0;  ///< steady clock; a camera's own stamp if it has one
  bool is_frozen = false;     ///< equal in every pixel to the one before: no camera's noise repeats
};

class PictureSource {
 public:
  /// Throws InputError if the device cannot be opened.
  explicit PictureSource(const PictureSourceOptions& options);
  ~PictureSource();

  /// Waits for the next picture. Throws InputError if none comes.
  TimedPicture next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
