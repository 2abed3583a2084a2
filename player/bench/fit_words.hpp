/// How well the markers of a body hold its pose, for people.
#pragma once

#include <string>

#include "tracking/body_pose.hpp"

namespace vrda {

/// What the noise that the fit's own residual speaks for makes of the pose: the least certain turn about any
/// axis and the place of the markers' middle, standard deviations. Zero where there is no fit.
struct FitQuality {
  double residual_mm = 0.0;  ///< at the markers used, root mean square
  int n_markers = 0;         ///< used
  double turn_sd_deg = 0.0, middle_sd_mm = 0.0;
};
FitQuality quality_of(const PoseFit& fit);

/// "0.12 mm off at 4 markers, turns known to 0.06 deg"; without a fit why.
std::string fit_text(const PoseFit& fit);

}  // namespace vrda
