/// What an eye sees of a leg and of the picture laid over it (thesis, figure 26).
#pragma once

#include <string>

#include "render/image.hpp"
#include "store/motion_model.hpp"
#include "virtual_bench/truth.hpp"

namespace vrda {

struct OverlayPictureOptions {
  std::string set;   ///< of the model
  int height = 560;  ///< px; the leg fills it
};

/// Through the left eye's true optics, with the stage before the leg: the leg as it is, grey (the model
/// itself, in the subject's true size), and added to it, since black is transparent, what a bench calibrated
/// so draws.
Image overlay_picture(const BenchFile& bench, const VirtualTruth& truth, const Calibration& calibration,
                      const MotionModel& model, const OverlayPictureOptions& options);

}  // namespace vrda
