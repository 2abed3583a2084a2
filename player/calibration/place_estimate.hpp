/// A place as an Estimate has it.
#pragma once

#include <string>

#include "calibration/estimate.hpp"
#include "core/mesh.hpp"

namespace vrda {

/// `covariance`: of the shift (mm) and of a small turn about the fixed axes (rad), as Estimate says. Six
/// numbers, each after `name` and a point; mm and deg.
Estimate place_estimate(const std::string& name, const Pose& X_fixed_moving,
                        const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace vrda
