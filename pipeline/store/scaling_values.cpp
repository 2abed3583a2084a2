#include "store/scaling_values.hpp"

namespace vrda {
namespace {

bool is_positive(double value)
{
  return is_number(value) && value > 0.0;
}

// Sums of squares of the pairs' distances, in another order perhaps.
bool is_near(double a, double b)
{
  return std::abs(a - b) <= exact_tolerance * (1.0 + std::abs(b));
}

void check_pairs(const Scaling& scaling, ValueFindings& findings)
{
  const std::size_t n = scaling.landmark.size();
  findings.each(
      "/job/scaling/landmark", n, "a name", [&](std::size_t i) { return scaling.landmark[i].empty(); },
      [](std::size_t) { return "nothing"; });
  findings.each_number("/job/scaling/model", scaling.model_mm.data(), n, "a distance above 0",
                       [&](std::size_t i) { return !is_positive(scaling.model_mm[i]); });
  findings.each_number("/job/scaling/subject", scaling.subject_mm.data(), n, "a distance above 0",
                       [&](std::size_t i) { return !is_positive(scaling.subject_mm[i]); });
  findings.each_number("/job/scaling/residual", scaling.residual_mm.data(), n,
                       "the subject's distance less the factor times the model's", [&](std::size_t i) {
                         return !is_near(scaling.residual_mm[i],
                                         scaling.subject_mm[i] - scaling.factor.x() * scaling.model_mm[i]);
                       });
}

}  // namespace

void check_scaling(const Scaling& scaling, ValueFindings& findings)
{
  const std::string group = "/job/scaling";
  const std::size_t n = scaling.landmark.size();
  findings.each_number(group + "@factor", scaling.factor.data(), 3, "numbers above 0",
                       [&](std::size_t i) { return !is_positive(scaling.factor.data()[i]); });
  if ((scaling.keeps_steps || n > 0) && !is_even(scaling.factor)) {
    findings.find(group + "@factor", "numbers that differ",
                  "one number three times where steps are kept or landmarks fitted");
  }
  check_pairs(scaling, findings);
  double sum_sq_mm2 = 0.0;
  for (const double residual_mm : scaling.residual_mm) sum_sq_mm2 += residual_mm * residual_mm;
  const double rms_mm = std::sqrt(sum_sq_mm2 / static_cast<double>(n));
  const bool is_rms = n == 0 ? std::isnan(scaling.residual_rms_mm) : is_near(scaling.residual_rms_mm, rms_mm);
  if (!is_rms) {
    findings.find(group + "@residual_rms_mm", text_of(scaling.residual_rms_mm),
                  n == 0 ? "NaN without landmarks" : text_of(rms_mm) + ", that of the residuals");
  }
  const double error = scaling.standard_error;
  if (n < 2 ? !std::isnan(error) : !(is_number(error) && error >= 0.0)) {
    findings.find(group + "@standard_error", text_of(error),
                  n < 2 ? "NaN below two pairs of landmarks" : "a number of at least 0");
  }
}

}  // namespace vrda
