#include "bench/fit_words.hpp"

#include <algorithm>

#include "core/units.hpp"
#include "settings/settings_text.hpp"

namespace vrda {

FitQuality quality_of(const PoseFit& fit)
{
  FitQuality quality;
  if (fit.status != FitStatus::fitted) return quality;
  const PoseError error = expected_error(fit.cloud, noise_mm(fit));
  quality.residual_mm = fit.residual_rms_mm;
  quality.n_markers = fit.cloud.n;
  quality.turn_sd_deg = deg_from_rad(error.turn_rad.maxCoeff());
  quality.middle_sd_mm = error.centre_mm;
  return quality;
}

std::string fit_text(const PoseFit& fit)
{
  if (fit.status != FitStatus::fitted) {
    std::string why = name_of(fit.status);
    std::replace(why.begin(), why.end(), '_', ' ');
    return why;
  }
  const FitQuality quality = quality_of(fit);
  return rounded_text(quality.residual_mm, 2) + " mm off at " + std::to_string(quality.n_markers) +
         " markers, turns known to " + rounded_text(quality.turn_sd_deg, 2) + " deg";
}

}  // namespace vrda
