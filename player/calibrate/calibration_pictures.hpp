/// Pictures of what a virtual bench found (thesis, figures 22, 23 and 26).
#pragma once

#include <string>
#include <vector>

#include "calibrate/calibrate.hpp"
#include "virtual_bench/operator.hpp"

namespace vrda {

struct PictureRequest {
  const BenchFile& bench;
  const VirtualTruth& truth;
  const Calibration& found;
  const std::vector<Task>& tasks;  ///< done; their marks stand in `found`
};

/// viewport.png, distortion.png, rectangles.png, bullseye.png and, with the options' model, overlay.png, into
/// their folder. Returns the paths. Throws InputError.
std::vector<std::string> write_calibration_pictures(const PictureRequest& request,
                                                    const CalibrateOptions& options);

}  // namespace vrda
