/// What a fit leaves at marks of two coordinates each, which stand first among its residuals.
#pragma once

#include "calibration/least_squares.hpp"

namespace vrda {

/// Degrees of freedom of the marks' noise: their coordinates less the share of the fitted numbers that they
/// determine (the trace of their part of the hat matrix); what was known before determines the rest.
double noise_dof(const LeastSquares& fit, Eigen::Index n_marks);

/// How far a mark lies from where all the others say, in standard deviations of the others' noise.
struct FurthestMark {
  Eigen::Index mark = 0;
  double deviations = 0.0;
  Eigen::Vector2d off = Eigen::Vector2d::Zero();  ///< in units of the mark's standard deviation
};
/// The furthest of them. The fit without each mark follows from the fit with all, as far as it is linear.
FurthestMark furthest_mark(const LeastSquares& fit, Eigen::Index n_marks);

}  // namespace vrda
