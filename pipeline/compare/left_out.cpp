#include "compare/left_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/perceptible.hpp"
#include "core/error.hpp"
#include "smooth/huber.hpp"

namespace vrda {
namespace {

/// Least limit of the squares, of what is perceptible: the scale of exact data is rounding, under which no
/// error would count.
constexpr double least_limit = 1e-3;

double unit_of(std::size_t surface)
{
  return surface < 3 ? perceptible_mm : perceptible_deg;
}

/// Some fitted cell of the fit cannot be left out.
bool is_saturated(const SmoothFit& fit)
{
  for (std::size_t s = 0; s < fit.left_out.size(); ++s) {
    if ((fit.left_out[s].isNaN() != fit.residual[s].isNaN()).any()) return true;
  }
  return false;
}

/// Where errors stop to count by their square: huber_constant times the smallest scale of any fit, in units
/// of what is perceptible.
double huber_limit(const std::vector<const SmoothFit*>& fits, std::size_t surface)
{
  double least = std::numeric_limits<double>::infinity();
  for (const SmoothFit* fit : fits) {
    std::vector<double> errors;
    for (const double error : fit->left_out[surface].reshaped<Eigen::RowMajor>()) {
      if (!std::isnan(error)) errors.push_back(error);
    }
    least = std::min(least, robust_scale(Eigen::Map<const Eigen::VectorXd>(
                                errors.data(), static_cast<Eigen::Index>(errors.size()))));
  }
  return std::max(least_limit, huber_constant * least / unit_of(surface));
}

/// Square of the error, from `limit` on the tangent of the square.
double loss(double error, double limit)
{
  const double size = std::abs(error);
  return size <= limit ? size * size : limit * (2.0 * size - limit);
}

/// Cells where every fit has this surface.
GridB cells_of_all(const std::vector<const SmoothFit*>& fits, std::size_t surface)
{
  GridB is_of_all =
      GridB::Ones(fits.front()->left_out[surface].rows(), fits.front()->left_out[surface].cols());
  for (const SmoothFit* fit : fits)
    is_of_all = is_of_all * (!fit->left_out[surface].isNaN()).cast<std::int8_t>();
  return is_of_all;
}

/// Adds one surface's losses to those of the cells, which are the fitted cells of translation in grid order.
void add_losses(DegreeErrors& errors, const SmoothFit& fit, std::size_t surface, const GridB& is_of_all,
                double limit)
{
  std::size_t cell = 0;
  for (Eigen::Index k = 0; k < is_of_all.size(); ++k) {
    if (std::isnan(fit.residual[0].data()[k])) continue;
    if (is_of_all.data()[k] == 1)
      errors.left_out_sq[cell] += loss(fit.left_out[surface].data()[k] / unit_of(surface), limit);
    ++cell;
  }
}

}  // namespace

std::vector<DegreeErrors> degree_errors(const std::vector<SmoothFit>& fits)
{
  std::vector<DegreeErrors> all;
  std::vector<const SmoothFit*> judged;
  for (const SmoothFit& fit : fits) {
    all.push_back({fit.set.degree, {}});
    if (is_saturated(fit)) continue;
    judged.push_back(&fit);
    all.back().left_out_sq.assign(static_cast<std::size_t>((!fit.residual[0].isNaN()).count()), 0.0);
  }
  if (judged.empty()) return all;
  for (std::size_t s = 0; s < judged.front()->left_out.size(); ++s) {
    const GridB is_of_all = cells_of_all(judged, s);
    const double limit =
        judged.front()->set.is_robust ? huber_limit(judged, s) : std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < fits.size(); ++k) {
      if (!all[k].left_out_sq.empty()) add_losses(all[k], fits[k], s, is_of_all, limit);
    }
  }
  return all;
}

}  // namespace vrda
