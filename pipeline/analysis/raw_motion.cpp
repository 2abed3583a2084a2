#include "analysis/raw_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

namespace vrda::analysis {
namespace {

/// Blocks of an axis, so that their spread is known and polynomials do not extrapolate far.
constexpr Eigen::Index least_blocks = 4;

double raw_value(const analysis::SmoothFit& fit, std::size_t surface, Eigen::Index i, Eigen::Index j)
{
  return fit.residual[surface](i, j) + fit.set.surfaces[surface].values(i, j);
}

/// Length of the step of the pose from flexion i to i + 1; NaN if a translation is missing. An angle that is
/// not fitted there does not count.
double step_length(const analysis::SmoothFit& fit, Eigen::Index i, Eigen::Index j)
{
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    const double step = (raw_value(fit, s, i + 1, j) - raw_value(fit, s, i, j)) / perceptible_unit(s);
    if (s < 3 || !std::isnan(step)) sum_sq += step * step;
  }
  return std::sqrt(sum_sq);
}

std::optional<double> median(std::vector<double> values)
{
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> median_excess(const analysis::SmoothFit& fit, Eigen::Index i)
{
  std::vector<double> excess;
  for (Eigen::Index j = 0; j < fit.residual[0].cols(); ++j) {
    const double before = step_length(fit, i - 1, j), here = step_length(fit, i, j),
                 after = step_length(fit, i + 1, j);
    if (!std::isnan(before + here + after)) excess.push_back(here - std::max(before, after));
  }
  return median(std::move(excess));
}

/// Smallest lag along an axis with (di, dj) of length 1 at which residuals are uncorrelated.
Eigen::Index correlation_length(const analysis::SmoothFit& fit, Eigen::Index di, Eigen::Index dj)
{
  const Eigen::Index rows = fit.residual[0].rows(), columns = fit.residual[0].cols();
  const Eigen::Index n_axis = di > 0 ? rows : columns;
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    for (const double r : fit.residual[s].reshaped())
      sum_sq += std::isnan(r) ? 0.0 : r * r / (perceptible_unit(s) * perceptible_unit(s));
  }
  const auto n_cells = static_cast<double>((!fit.residual[0].isNaN()).count());
  for (Eigen::Index lag = 1; lag < n_axis; ++lag) {
    double products = 0.0, n_pairs = 0.0;
    for (std::size_t s = 0; s < fit.residual.size(); ++s) {
      const store::GridD& r = fit.residual[s];
      for (Eigen::Index i = 0; i + lag * di < rows; ++i) {
        for (Eigen::Index j = 0; j + lag * dj < columns; ++j) {
          const double product =
              r(i, j) * r(i + lag * di, j + lag * dj) / (perceptible_unit(s) * perceptible_unit(s));
          if (std::isnan(product)) continue;
          products += product;
          n_pairs += s == 0 ? 1.0 : 0.0;
        }
      }
    }
    if (n_pairs == 0.0 || sum_sq <= rounding_sq * n_cells) return lag;
    if (products / n_pairs * n_cells / sum_sq < 2.0 / std::sqrt(n_pairs)) return lag;
  }
  return n_axis;
}

Eigen::Index block_length(Eigen::Index correlation_length, Eigen::Index n_axis)
{
  return std::min(2 * correlation_length - 1, std::max<Eigen::Index>(1, n_axis / least_blocks));
}

}  // namespace

RawJump largest_jump(const std::vector<double>& flexion_deg, const analysis::SmoothFit& fit)
{
  RawJump largest;
  for (Eigen::Index i = 1; i + 2 < fit.residual[0].rows(); ++i) {
    const std::optional<double> excess = median_excess(fit, i);
    const auto row = static_cast<std::size_t>(i);
    if (excess && *excess > largest.size) largest = {*excess, flexion_deg[row], flexion_deg[row + 1]};
  }
  return largest;
}

RawJump raw_jump(const store::MotionModel& model)
{
  if (model.frames || !(model.status == status_stable).any()) return {};
  // Any degree has the raw values; a constant is determined by a single cell.
  return largest_jump(model.flexion_deg, analysis::smooth_fit(analysis::smooth_input(model, model.title), 0));
}

std::string jump_text(const RawJump& jump)
{
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "the raw motion jumps by %.3g times the perceptible error between flexion %.3g and %.3g degrees",
      jump.size, jump.from_deg, jump.to_deg);
  return text.data();
}

double raw_variance(const analysis::SmoothFit& fit)
{
  double sum_sq = 0.0;
  for (std::size_t s = 0; s < fit.residual.size(); ++s) {
    std::vector<double> values;
    double mean = 0.0;
    for (Eigen::Index i = 0; i < fit.residual[s].rows(); ++i) {
      for (Eigen::Index j = 0; j < fit.residual[s].cols(); ++j) {
        if (std::isnan(fit.residual[s](i, j))) continue;
        values.push_back(raw_value(fit, s, i, j) / perceptible_unit(s));
        mean += values.back();
      }
    }
    mean /= static_cast<double>(values.size());
    for (const double value : values) sum_sq += (value - mean) * (value - mean);
  }
  return sum_sq / static_cast<double>((!fit.residual[0].isNaN()).count());
}

analysis::BlockSize correlated_block(const analysis::SmoothFit& fit)
{
  return {block_length(correlation_length(fit, 1, 0), fit.residual[0].rows()),
          block_length(correlation_length(fit, 0, 1), fit.residual[0].cols())};
}

}  // namespace vrda::analysis
