#include "calibration/scale_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "settings/settings_text.hpp"
#include "tracking/fit_refusal.hpp"

namespace vrda {
namespace {

constexpr std::size_t least_distances = 3;
constexpr double least_scale = 0.5, most_scale = 2.0;
constexpr double uneven_ratio = 1.05, uneven_rms_mm = 2.0;

void require_distances(std::span<const LandmarkDistance> distances, const std::string& file)
{
  if (distances.size() < least_distances) {
    throw FitRefusal({file, "landmarks", std::to_string(distances.size()) + " distances",
                      "three or more: one says nothing of whether an even scale fits"});
  }
  for (std::size_t k = 0; k < distances.size(); ++k) {
    const LandmarkDistance& d = distances[k];
    for (const double mm : {d.model_mm, d.subject_mm}) {
      const bool is_length = mm > 0.0 && std::isfinite(mm);
      if (!is_length) {
        throw FitRefusal({file, d.name,
                          rounded_text(d.model_mm, 2) + " mm of the model, " + rounded_text(d.subject_mm, 2) +
                              " mm of the subject",
                          "distances above 0"},
                         {k});
      }
    }
  }
}

std::string percent(double scale)
{
  return rounded_text(100.0 * scale, 1) + " %";
}

}  // namespace

ScaleFit fit_scale(std::span<const LandmarkDistance> distances, const std::string& file)
{
  require_distances(distances, file);
  double with_subject = 0.0, with_model = 0.0;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const LandmarkDistance& d : distances) {
    with_subject += d.model_mm * d.subject_mm;
    with_model += d.model_mm * d.model_mm;
    least = std::min(least, d.subject_mm / d.model_mm);
    most = std::max(most, d.subject_mm / d.model_mm);
  }
  ScaleFit fit;
  fit.scale = with_subject / with_model;
  if (!(fit.scale >= least_scale && fit.scale <= most_scale)) {
    throw FitRefusal({file, "landmarks", "a scale of " + rounded_text(fit.scale, 3),
                      "0.5 to 2: are both in mm, and of the same landmarks?"});
  }
  std::vector<double> left_mm;
  double sum_sq_mm2 = 0.0;
  for (const LandmarkDistance& d : distances) {
    left_mm.push_back(d.subject_mm - fit.scale * d.model_mm);
    sum_sq_mm2 += left_mm.back() * left_mm.back();
  }
  Estimate& estimate = fit.estimate;
  estimate.names = {"subject.scale"};
  estimate.units = {""};
  estimate.values = Eigen::VectorXd::Constant(1, fit.scale);
  estimate.dof = static_cast<double>(distances.size()) - 1.0;
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, sum_sq_mm2 / estimate.dof / with_model);
  set_residuals(estimate, left_mm, "mm");
  fit.is_uneven = most > uneven_ratio * least && estimate.residual_rms > uneven_rms_mm;
  if (fit.is_uneven) {
    estimate.remarks.push_back(
        "the distances ask for " + percent(least) + " to " + percent(most) +
        " of the model: one scale does not fit; run the pipeline on the subject's own bones");
  }
  return fit;
}

}  // namespace vrda
