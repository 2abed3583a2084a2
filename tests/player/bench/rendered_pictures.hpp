/// Pictures of printed bodies as a webcam takes them, with known poses: rays through a distorting lens, the
/// area of each pixel sampled, blur, noise.
#pragma once

#include "bench/webcam.hpp"

namespace vrda::test {

/// A rectangle of one brightness in front of everything, px.
struct Occluder {
  int x = 0, y = 0, width = 0, height = 0;
};

struct RenderedPicture {
  std::vector<Pose> X_camera_body;  ///< of body 0, 1, ...
  std::vector<Occluder> occluders = {};
  double blur_px = 0.8;     ///< standard deviation of a Gaussian
  double noise_grey = 4.0;  ///< standard deviation, of 255
  std::uint64_t seed = 1;
  double fold_deg = 90.0;  ///< of the sheets
};

/// A webcam's lens: 56 degrees wide, with barrel distortion.
bench::Camera webcam_camera();

bench::GreyPicture rendered(const bench::Camera& camera, const RenderedPicture& picture);

/// Brightness, 0 to 255, of a plane z = 0 of a board at x, y (mm).
using PlanePattern = std::function<double(double x_mm, double y_mm)>;

/// The board for the camera's calibration: x to the right and y down from the upper left corner of the board.
bench::GreyPicture rendered_plane(const bench::Camera& camera, const Pose& X_camera_plane,
                                  const PlanePattern& pattern, const RenderedPicture& appearance);

}  // namespace vrda::test
