/// Figures of a curve over flexion: those of a rotation along the spine (screw-home) that are printed.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

/// The finite number for which `is_beyond` any other finite one, of a vector or array; NaN without one.
template <typename Values, typename Compare>
double extreme_of(const Values& values, const Compare& is_beyond)
{
  double extreme = nan;
  for (decltype(values.size()) k = 0; k < values.size(); ++k) {
    const double value = values.data()[k];
    if (std::isfinite(value) && (std::isnan(extreme) || is_beyond(value, extreme))) extreme = value;
  }
  return extreme;
}
/// Largest and smallest finite number of a vector or array; NaN without one.
template <typename Values>
double largest_of(const Values& values)
{
  return extreme_of(values, std::greater<>());
}
template <typename Values>
double smallest_of(const Values& values)
{
  return extreme_of(values, std::less<>());
}

/// Values at flexions, both in degrees; NaN where there is no pose.
struct FlexionCurve {
  std::vector<double> flexion_deg, value_deg;
};

/// Signed changes in degrees and the flexions where they are; NaN without two values.
struct CurveFigures {
  double first_deg = nan, last_deg = nan;    ///< flexions of the first and last value
  double net_deg = nan;                      ///< last value less the first
  double peak_deg = nan, peak_at_deg = nan;  ///< value farthest from the first, less that
  double change_deg = nan, change_from_deg = nan, change_to_deg = nan;  ///< largest within change_window_deg
};
inline constexpr double change_window_deg = 5.0;

/// The largest change is that of the polygon through the values between two flexions at most
/// change_window_deg apart; NaN if flexion does not increase, as in a sequence of frames.
CurveFigures curve_figures(const FlexionCurve& curve);

/// Internal rotation at the spine cell of each flexion that has one.
FlexionCurve spine_rotation(const store::MotionModel& model);

/// The largest change of theta between neighbouring flexions of the spine that are both solved; NaN without,
/// and for a sequence of frames.
struct SpineJump {
  double change_deg = nan;  ///< absolute
  double from_deg = nan, to_deg = nan;
};
/// A larger change is a discontinuity.
inline constexpr double spine_jump_deg = 3.0;
SpineJump spine_jump(const store::MotionModel& model);

/// "theta jumps by 12.6 degrees between flexion 5 and 10 of the spine"; empty up to spine_jump_deg.
std::string text_of(const SpineJump& jump);

/// "net +2.1 degrees from flexion 0 to 90, peak +9.8 at 38, largest change +11.8 per 5 degrees of flexion (40
/// to 45)"; "none" without two values.
std::string text_of(const CurveFigures& figures);

}  // namespace vrda::store
