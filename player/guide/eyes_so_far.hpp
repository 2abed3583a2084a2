/// The eyes as the parts before the bull's-eye found them, whatever was changed by hand since.
#pragma once

#include <array>

#include "setup/calibration.hpp"

namespace vrda {

/// Puts what `part` (viewport, distortion, eyepoints or ipd) found into `eyes`.
void put_found(EyePair& eyes, CalibrationPart part, const Estimate& found);

/// Of nominal eyes and the estimates of all those parts before `part`.
EyePair eyes_before(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

/// The part's estimate. Throws InputError naming `path` where it has none.
const Estimate& estimate_of(CalibrationPart part, const Calibration& calibration, const std::string& path);

/// Block of an estimate's covariance that belongs to `names`, as whoever uses it as known has to take it: of
/// the normal distribution with the same 95 % intervals.
Eigen::MatrixXd known_covariance(const Estimate& estimate, const std::vector<std::string>& names);

double value_in(const Estimate& estimate, const std::string& name);
/// Of the six numbers "name.shift_x" to "name.turn_z".
Pose place_in(const Estimate& estimate, const std::string& name);
/// "left", "right"
const char* side_text(bool is_right);
/// Names of one eye's distortion: "left.k1", ...
std::vector<std::string> distortion_names(bool is_right);

}  // namespace vrda
