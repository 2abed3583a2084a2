/// A calibrated camera and its file (schemas/bench.md).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vrda::bench {

/// Pinhole camera with the lens distortion of Brown (1966): k1, k2, p1, p2, k3.
struct Camera {
  int width = 640, height = 480;  ///< px
  Eigen::Vector2d focal_px = Eigen::Vector2d::Constant(600.0);
  Eigen::Vector2d centre_px{319.5, 239.5};  ///< pixel centres are at whole numbers
  std::array<double, 5> distortion{};
  double rms_px = 0.0;  ///< of the calibration
  int n_views = 0;
};

/// Throws InputError with file and key.
Camera read_camera(const std::string& path);
std::string camera_text(const Camera& camera);

/// A grey picture, row by row from the upper left.
struct GreyPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

}  // namespace vrda::bench
