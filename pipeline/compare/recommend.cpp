#include "compare/recommend.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/error.hpp"
#include "core/perceptible.hpp"
#include "core/units.hpp"
#include "smooth/huber.hpp"

namespace vrda::compare {
namespace {

constexpr double standard_errors = 2.0;
/// Square of a millionth of the perceptible error: 0.1 nanometres.
constexpr double rounding_sq = 1e-12;

double mean(const std::vector<double>& values)
{
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::vector<double> at_least_rounding(std::vector<double> errors_sq)
{
  for (double& error_sq : errors_sq) error_sq = std::max(error_sq, rounding_sq);
  return errors_sq;
}

RankedDegree ranked_against(const std::vector<double>& best_sq, const DegreeErrors& errors)
{
  RankedDegree ranked{errors.degree, nan, nan, nan, false};
  if (errors.leave_one_out_sq.empty()) return ranked;
  check(errors.leave_one_out_sq.size() == best_sq.size(), "every degree has the same cells");
  std::vector<double> difference = at_least_rounding(errors.leave_one_out_sq);
  ranked.error = std::sqrt(mean(difference));
  for (std::size_t c = 0; c < difference.size(); ++c) difference[c] -= best_sq[c];
  ranked.excess_sq = mean(difference);
  double spread_sq = 0.0;
  for (const double d : difference) spread_sq += (d - ranked.excess_sq) * (d - ranked.excess_sq);
  const double n = static_cast<double>(difference.size());
  ranked.standard_error = n > 1.0 ? std::sqrt(spread_sq / (n - 1.0) / n) : 0.0;
  ranked.is_within = ranked.excess_sq <= standard_errors * ranked.standard_error;
  return ranked;
}

std::string text_of(double number)
{
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

/// The comparison with the degree below the chosen one; empty without its error.
std::string why_not_lower(const Recommendation& r, std::size_t chosen)
{
  if (chosen == 0) return "; no lower degree was compared";
  const RankedDegree& lower = r.ranked[chosen - 1];
  if (std::isnan(lower.error)) return "";
  // Without spread the difference is the same at every cell.
  if (lower.standard_error == 0.0)
    return "; degree " + std::to_string(lower.degree) + " is worse at every cell";
  return "; degree " + std::to_string(lower.degree) + " (" + text_of(lower.error) + ") is " +
         text_of(lower.excess_sq / lower.standard_error) + " standard errors worse";
}

std::string reason_of(const Recommendation& r, std::size_t chosen, std::size_t best)
{
  std::string reason = "degree " + std::to_string(r.degree) + ": ";
  const std::string error = text_of(r.ranked[chosen].error) + " times the perceptible error";
  if (chosen == best) {
    reason += "smallest leave-one-out error (" + error +
              "), and no lower degree is within two paired standard errors";
  } else {
    reason += "lowest degree whose leave-one-out error (" + error +
              ") is within two paired standard errors of the best (" + text_of(r.ranked[best].error) +
              ", degree " + std::to_string(r.best_degree) + ")";
  }
  reason += why_not_lower(r, chosen);
  if (chosen + 1 == r.ranked.size() && chosen > 0)
    reason += "; the error still decreases at the highest compared degree";
  return reason;
}

}  // namespace

Recommendation recommend(const std::vector<DegreeErrors>& degrees)
{
  Recommendation r;
  std::size_t best = degrees.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < degrees.size(); ++k) {
    check(k == 0 || degrees[k - 1].degree < degrees[k].degree, "degrees ascend");
    if (degrees[k].leave_one_out_sq.empty()) continue;
    const double error_sq = mean(at_least_rounding(degrees[k].leave_one_out_sq));
    if (error_sq >= least) continue;
    least = error_sq;
    best = k;
  }
  if (best == degrees.size()) {
    r.reason = "no degree: for every degree a cell cannot be omitted";
    for (const DegreeErrors& errors : degrees) r.ranked.push_back({errors.degree, nan, nan, nan, false});
    return r;
  }
  const std::vector<double> best_sq = at_least_rounding(degrees[best].leave_one_out_sq);
  for (const DegreeErrors& errors : degrees) r.ranked.push_back(ranked_against(best_sq, errors));
  const auto chosen =
      std::find_if(r.ranked.begin(), r.ranked.end(), [](const RankedDegree& d) { return d.is_within; });
  r.degree = chosen->degree;
  r.best_degree = degrees[best].degree;
  r.reason = reason_of(r, static_cast<std::size_t>(chosen - r.ranked.begin()), best);
  return r;
}

namespace {

/// Lower bound of the Huber limit, in perceptible units: the scale of exact data is rounding, and no error
/// would count.
constexpr double least_limit = 1e-3;

double unit_of(std::size_t surface)
{
  return surface < 3 ? perceptible_mm : perceptible_deg;
}

/// True if a fitted cell cannot be omitted.
bool is_saturated(const smooth::SmoothFit& fit)
{
  for (std::size_t s = 0; s < fit.leave_one_out.size(); ++s) {
    if ((fit.leave_one_out[s].isNaN() != fit.residual[s].isNaN()).any()) return true;
  }
  return false;
}

/// Error above which the loss is linear: huber_constant times the smallest scale of any fit, in perceptible
/// units.
double huber_limit(const std::vector<const smooth::SmoothFit*>& fits, std::size_t surface)
{
  double least = std::numeric_limits<double>::infinity();
  for (const smooth::SmoothFit* fit : fits) {
    std::vector<double> errors;
    for (const double error : fit->leave_one_out[surface].reshaped<Eigen::RowMajor>()) {
      if (!std::isnan(error)) errors.push_back(error);
    }
    least = std::min(least, smooth::robust_scale(Eigen::Map<const Eigen::VectorXd>(
                                errors.data(), static_cast<Eigen::Index>(errors.size()))));
  }
  return std::max(least_limit, smooth::huber_constant * least / unit_of(surface));
}

/// Square of the error; above `limit` the tangent of the square.
double loss(double error, double limit)
{
  const double size = std::abs(error);
  return size <= limit ? size * size : limit * (2.0 * size - limit);
}

/// 1 for cells where every fit has this surface.
store::GridB cells_of_all(const std::vector<const smooth::SmoothFit*>& fits, std::size_t surface)
{
  store::GridB is_of_all = store::GridB::Ones(fits.front()->leave_one_out[surface].rows(),
                                              fits.front()->leave_one_out[surface].cols());
  for (const smooth::SmoothFit* fit : fits)
    is_of_all = is_of_all * (!fit->leave_one_out[surface].isNaN()).cast<std::int8_t>();
  return is_of_all;
}

/// Adds the losses of one surface to the cells (those fitted in translation, in grid order).
void add_losses(DegreeErrors& errors, const smooth::SmoothFit& fit, std::size_t surface,
                const store::GridB& is_of_all, double limit)
{
  std::size_t cell = 0;
  for (Eigen::Index k = 0; k < is_of_all.size(); ++k) {
    if (std::isnan(fit.residual[0].data()[k])) continue;
    if (is_of_all.data()[k] == 1)
      errors.leave_one_out_sq[cell] += loss(fit.leave_one_out[surface].data()[k] / unit_of(surface), limit);
    ++cell;
  }
}

}  // namespace

std::vector<DegreeErrors> degree_errors(const std::vector<smooth::SmoothFit>& fits)
{
  std::vector<DegreeErrors> all;
  std::vector<const smooth::SmoothFit*> usable;
  for (const smooth::SmoothFit& fit : fits) {
    all.push_back({fit.set.degree, {}});
    if (is_saturated(fit)) continue;
    usable.push_back(&fit);
    all.back().leave_one_out_sq.assign(static_cast<std::size_t>((!fit.residual[0].isNaN()).count()), 0.0);
  }
  if (usable.empty()) return all;
  for (std::size_t s = 0; s < usable.front()->leave_one_out.size(); ++s) {
    const store::GridB is_of_all = cells_of_all(usable, s);
    const double limit =
        usable.front()->set.is_robust ? huber_limit(usable, s) : std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < fits.size(); ++k) {
      if (!all[k].leave_one_out_sq.empty()) add_losses(all[k], fits[k], s, is_of_all, limit);
    }
  }
  return all;
}

}  // namespace vrda::compare
