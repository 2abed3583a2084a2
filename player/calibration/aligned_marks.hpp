/// What a fit leaves at marks of two coordinates each, which stand first among its residuals.
#pragma once

#include "calibration/least_squares.hpp"

namespace vrda {

/// Noise of an alignment by eye that fits begin with.
inline constexpr double start_noise_px = 0.5;
/// No hand aligns better; keeps weights finite where marks fit exactly.
inline constexpr double least_noise_px = 1e-4;

/// Degrees of freedom of the marks' noise: their coordinates less the share of the fitted numbers that they
/// determine (the trace of their part of the hat matrix); what was known before determines the rest.
double noise_dof(const LeastSquares& fit, Eigen::Index n_marks);

/// One for the intervals of all numbers `to_numbers` x [k, n]: the variance of what was known before is not
/// uncertain as that of the noise is, so a number has more than noise_dof(), the more the smaller the marks'
/// share of its variance. That of the mean share; infinite where the marks tell nothing. Source:
/// Satterthwaite (1946) Biometrics Bulletin 2, of two variances one known.
double interval_dof(const LeastSquares& fit, Eigen::Index n_marks, const Eigen::MatrixXd& to_numbers);

/// How far a mark lies from where all the others say, in standard deviations of the others' noise.
struct FurthestMark {
  Eigen::Index mark = 0;
  double deviations = 0.0;
  Eigen::Vector2d off = Eigen::Vector2d::Zero();  ///< in units of the mark's standard deviation
};
/// The furthest of them. The fit without each mark follows from the fit with all, as far as it is linear.
FurthestMark furthest_mark(const LeastSquares& fit, Eigen::Index n_marks);

}  // namespace vrda
