/// A subject's size, from distances between landmarks.
#pragma once

#include <span>

#include "calibration/estimate.hpp"

namespace vrda {

struct LandmarkDistance {
  std::string name;
  double model_mm = 0.0, subject_mm = 0.0;
};

struct ScaleFit {
  double scale = 1.0;
  /// The distances ask for different scales: more than 5 % apart, and by more than the 2 mm (residuals' rms)
  /// that finding landmarks through skin leaves anyway. No known noise of them could decide it by a test.
  bool is_uneven = false;
  Estimate estimate;  ///< "subject.scale"; residuals: subject's less scaled model's, mm
};

/// Least squares through the origin. Throws FitRefusal naming `file`: fewer than three distances, one that is
/// not above 0, a scale outside 0.5 to 2.
ScaleFit fit_scale(std::span<const LandmarkDistance> distances, const std::string& file);

}  // namespace vrda
