/// Pictures of the calibration of a virtual bench (thesis, figures 22, 23 and 26).
#pragma once

#include "calibration/calibrate.hpp"
#include "calibration/virtual_bench.hpp"

namespace vrda::calibration {

struct PictureRequest {
  const BenchFile& bench;
  const VirtualTruth& truth;
  const Calibration& found;
  const std::vector<Task>& tasks;  ///< finished tasks; their marks are in `found`
};

/// Writes viewport.png, distortion.png, rectangles.png, bullseye.png and, with a model, overlay.png to the
/// folder of the options. Returns the paths. Throws InputError.
std::vector<std::string> write_calibration_pictures(const PictureRequest& request,
                                                    const CalibrateOptions& options);

}  // namespace vrda::calibration
