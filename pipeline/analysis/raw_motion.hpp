/// Properties of the raw motion that bound what a polynomial can reach: steps between neighbouring flexions,
/// variance, correlation of residuals. Lengths count in perceptible errors of 0.145 mm, angles in those of
/// 0.27 degrees.
#pragma once

#include <string>

#include "core/units.hpp"
#include "analysis/leave_out.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// Of surface 0 to 2 (tx, ty, tz) in mm, of the angles after them in degrees, as the surfaces are stored.
inline double perceptible_unit(std::size_t surface)
{
  return surface < 3 ? perceptible_mm : deg_from_rad(perceptible_rad);
}

/// Squared errors below this, of a millionth of a perceptible error, are rounding: 0.1 nanometres.
inline constexpr double rounding_sq = 1e-12;

/// A step between neighbouring flexions that exceeds the steps before and after it.
struct RawJump {
  double size = 0.0;  ///< excess over the longer of both steps, in perceptible errors; 0 without any
  double from_deg = 0.0, to_deg = 0.0;
};

/// A polynomial passes halfway through a step, so every degree is off by half of it on both sides. Facets of
/// the generic knee cause steps of 6 perceptible errors in half of the varus columns, a single outlier none.
inline constexpr double largest_raw_jump = 10.0;

/// Poses as in left_out_errors() (compare/recommend.hpp), in perceptible errors. The excess of a flexion is
/// the median over the varus columns solved at its four neighbouring flexions, so that steps of single cells
/// do not count. `fit` gives the raw values.
RawJump largest_jump(const std::vector<double>& flexion_deg, const analysis::SmoothFit& fit);

/// That of the model's raw poses; 0 for a sequence of frames or without solved cells.
RawJump raw_jump(const store::MotionModel& model);

/// "the raw motion jumps by 34 times the perceptible error between flexion 40 and 45 degrees".
std::string jump_text(const RawJump& jump);

/// Mean square of the raw pose about its mean, in squared perceptible errors, over the cells that are fitted.
double raw_variance(const analysis::SmoothFit& fit);

/// Blocks whose central cell is farther from all others than the residuals are correlated: 2 L - 1 cells
/// along an axis, where L is the smallest lag at which the autocorrelation of the residuals is below two
/// standard errors of white noise (Bartlett), 2 / sqrt(number of pairs of cells). At most a quarter of the
/// axis: polynomials do not extrapolate far. White noise and rounding give single cells.
analysis::BlockSize correlated_block(const analysis::SmoothFit& fit);

}  // namespace vrda::analysis
