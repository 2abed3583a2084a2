#include "solve/spread.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::solve {
namespace {

constexpr const char* units[] = {"degree", "mm", "N"};

const std::vector<double>& samples_of(const store::UncertainMotion& motion, std::size_t quantity)
{
  return quantity < 3 ? motion.rotation_deg : quantity < 6 ? motion.translation_mm : motion.contact_force_n;
}

const std::vector<double>& bands_of(const store::UncertainMotion& motion, std::size_t quantity)
{
  return quantity < 3   ? motion.rotation_band_deg
         : quantity < 6 ? motion.translation_band_mm
                        : motion.contact_force_band_n;
}

}  // namespace

std::vector<BandQuantity> quantities_of(const store::UncertainMotion& motion)
{
  std::vector<BandQuantity> quantities;
  for (std::size_t q = 0; q < store::uncertain_quantities.size(); ++q) {
    const std::vector<double>& samples = samples_of(motion, q);
    bool has_number = false;
    for (std::size_t at = q % 3; at < samples.size() && !has_number; at += 3)
      has_number = std::isfinite(samples[at]);
    if (has_number) quantities.push_back({q, store::uncertain_quantities[q], units[q / 3]});
  }
  return quantities;
}

double band_at(const store::UncertainMotion& motion, std::size_t probability, std::size_t flexion,
               std::size_t quantity)
{
  const std::size_t n_flexion = motion.n_solved.size();
  return bands_of(motion, quantity).at(3 * (probability * n_flexion + flexion) + quantity % 3);
}

std::vector<double> variances_of(const store::UncertainMotion& motion, std::size_t quantity)
{
  const std::vector<double>& samples = samples_of(motion, quantity);
  const std::size_t n_flexion = motion.n_solved.size();
  std::vector<double> variances;
  for (std::size_t i = 0; i < n_flexion; ++i) {
    double n = 0.0, sum = 0.0, squares = 0.0;
    const double near = band_at(motion, 2, i, quantity);  // the median, against cancellation
    for (std::size_t s = 0; s < motion.n_samples(); ++s) {
      const double value = samples[3 * (s * n_flexion + i) + quantity % 3] - near;
      if (!std::isfinite(value)) continue;
      n += 1.0;
      sum += value;
      squares += value * value;
    }
    variances.push_back(n > 1.0 ? (squares - sum * sum / n) / (n - 1.0) : 0.0);
  }
  return variances;
}

std::vector<SpreadShare> spread_shares(const store::UncertainMotion& motion, std::size_t quantity)
{
  const std::vector<double> variances = variances_of(motion, quantity);
  const std::size_t n_draws = motion.draw.size(), n_quantities = store::uncertain_quantities.size();
  std::vector<SpreadShare> shares;
  for (std::size_t d = 0; d < n_draws; ++d) {
    SpreadShare share{d};
    double weights = 0.0;
    for (std::size_t i = 0; i < variances.size(); ++i) {
      const std::size_t at = (i * n_quantities + quantity) * n_draws + d;
      if (!std::isfinite(motion.first_order[at])) continue;
      weights += variances[i];
      share.index += variances[i] * motion.first_order[at];
      share.low += variances[i] * motion.first_order_low[at];
      share.high += variances[i] * motion.first_order_high[at];
      share.rank_correlation += variances[i] * motion.rank_correlation[at];
    }
    if (!(weights > 0.0)) continue;
    for (double* value : {&share.index, &share.low, &share.high, &share.rank_correlation}) *value /= weights;
    shares.push_back(share);
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const SpreadShare& a, const SpreadShare& b) { return a.index > b.index; });
  return shares;
}

}  // namespace vrda::solve
