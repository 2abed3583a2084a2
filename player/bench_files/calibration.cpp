#include "bench_files/calibration.hpp"

#include "optics/viewport.hpp"

namespace vrda::bench_files {
namespace {

optics::Eye nominal_eye(const optics::Viewport& window, double x_mm)
{
  constexpr double nominal_distance_px = 880.0;
  optics::Eye eye;
  eye.window = eye.visible = window;
  eye.distance_px = nominal_distance_px;
  eye.sight_px = optics::middle_px(window);
  eye.position_head_mm = {x_mm, 0.0, 0.0};
  eye.distortion.centre_px = eye.sight_px;
  eye.distortion.unit_px = 0.5 * window.width;
  return eye;
}

}  // namespace

Calibration nominal_calibration(const BenchFile& bench)
{
  constexpr double nominal_ipd_mm = 64.0, nominal_depth_mm = 800.0;
  Calibration calibration;
  calibration.eyes.left = nominal_eye(bench.display.windows.left, -0.5 * nominal_ipd_mm);
  calibration.eyes.right = nominal_eye(bench.display.windows.right, 0.5 * nominal_ipd_mm);
  calibration.image_distance_mm = nominal_depth_mm;
  calibration.X_table_eyes.shift_mm = {0.0, 0.0, nominal_depth_mm};
  return calibration;
}

}  // namespace vrda::bench_files
