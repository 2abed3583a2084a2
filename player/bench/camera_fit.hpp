/// Calibration of a camera from pictures of the printed board (body_sheet.hpp).
#pragma once

#include <memory>
#include <string>

#include "bench/camera.hpp"

namespace vrda::bench {

struct CameraFitOptions {
  int n_views = 20;
};

/// Collects views of the board and fits the camera to them.
class CameraFit {
 public:
  explicit CameraFit(const CameraFitOptions& options = {});
  ~CameraFit();

  /// Takes a picture if it shows the board differently from all earlier views. Returns the outcome:
  /// "view 3 of 20", or why it was left out.
  std::string take(const GreyPicture& picture);
  bool is_complete() const;

  /// Throws InputError naming `file` if the views cannot determine the camera: an error above 1 px, or a
  /// focal length known to less than 1 %.
  Camera camera(const std::string& file) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::bench
