/// Motion over flexion of the samples of an uncertain job, their bands, and the inputs that the spread comes
/// from. Units here are those of the file: mm, degrees, N.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vrda::store {

/// Probabilities of the bands.
inline constexpr std::array<double, 5> band_probabilities{0.0, 0.05, 0.5, 0.95, 1.0};

/// Rows of the tables of correlation and index: three rotations, three translations, three contact forces.
inline constexpr std::array<const char*, 9> uncertain_quantities{
    "flexion", "varus", "internal", "anterior", "proximal", "lateral",
    "contact_force", "contact_force_medial", "contact_force_lateral"};

/// Samples whose pose is not stable at a flexion have NaN there and are left out of the statistics.
struct UncertainMotion {
  std::string sequence;  ///< "sobol" or "latin-hypercube"
  std::int32_t seed = 0;
  std::vector<std::string> draw;  ///< [n_draws] names of the independent draws
  std::vector<double> value;      ///< [n_samples, n_draws] factors, changes or scores
  std::vector<std::int8_t> status;       ///< [n_samples, n_flexion] StepStatus
  std::vector<double> rotation_deg;      ///< [n_samples, n_flexion, 3] flexion, varus, internal
  std::vector<double> translation_mm;    ///< [n_samples, n_flexion, 3] anterior, proximal, lateral
  std::vector<double> contact_force_n;   ///< [n_samples, n_flexion, 3] all, medial, lateral; NaN: no compartments
  std::vector<std::int32_t> n_solved;    ///< [n_flexion] stable samples
  std::vector<double> probability;       ///< [5] band_probabilities
  std::vector<double> rotation_band_deg;     ///< [5, n_flexion, 3] quantiles
  std::vector<double> translation_band_mm;   ///< [5, n_flexion, 3]
  std::vector<double> contact_force_band_n;  ///< [5, n_flexion, 3]
  std::vector<double> tension_band_n;        ///< [5, n_flexion, n_fibres]
  /// [5] At each of the probabilities a sample: when the samples that are solved at most flexions are ordered
  /// by internal rotation, as mean over flexion. Its motion as that of the two-sided motion, [5, n_flexion].
  std::vector<std::int32_t> quantile_sample;
  std::vector<std::int8_t> quantile_status;  ///< StepStatus
  std::vector<double> tx_mm, ty_mm, tz_mm, theta_deg, varus_deg;  ///< NaN where not stable
  std::vector<std::string> quantity;         ///< [9] uncertain_quantities
  /// [n_flexion, 9, n_draws] Spearman's rank correlation, and first-order Sobol index with its 90 % interval;
  /// NaN where the quantity has no spread.
  std::vector<double> rank_correlation, first_order, first_order_low, first_order_high;

  std::size_t n_samples() const { return n_solved.empty() ? 0 : status.size() / n_solved.size(); }
};

}  // namespace vrda::store
