/// The case of each sample: draws of the uncertain inputs applied to the case of the job.
#pragma once

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "job/case.hpp"

namespace vrda::job {

/// `job_case` must have an uncertainty, be at the subject's size, and outlive the object.
class SampledCase {
 public:
  /// Draws all samples. Throws InputError for more draws than the Sobol sequence has dimensions.
  explicit SampledCase(const job::Case& job_case);
  ~SampledCase();
  SampledCase(SampledCase&&) noexcept;

  int n_samples() const;
  /// One name for each independent draw, as "stiffness ACL" or "attachment moving MCL proximal".
  const std::vector<std::string>& draw_names() const;
  /// [n_samples, n_draws] standard normal scores.
  const Eigen::MatrixXd& scores() const;
  /// [n_samples, n_draws] factors and changes drawn; of draws that are correlated afterwards their scores.
  const Eigen::MatrixXd& values() const;

  /// The case of a sample, without uncertainty.
  job::Case at(int sample) const;
  /// Only its fibres, or its rotation centre.
  model::Ligaments ligaments_at(int sample) const;
  Eigen::Vector3d rotation_centre_mm_at(int sample) const;
  /// Whether the meshes and the rotation centre are those of the job for every sample.
  bool has_same_geometry() const;
  /// Of both objects together, where every sample's meshes differ from the job's in the thickness of a whole
  /// object only.
  std::optional<double> thickness_change_mm(int sample) const;

 private:
  std::ptrdiff_t n_geometry_changes() const;
  struct State;
  std::unique_ptr<State> state_;
};

/// Number of dimensions of the Sobol sequence (Joe and Kuo, direction numbers of Boost).
inline constexpr std::size_t most_sobol_dimensions = 3667;

/// Samples of the unit cube, [n_samples, n_dimensions], above 0 and below 1: the same numbers for the same
/// arguments on every machine. `sobol`: the sequence from its first point, with a random
/// digital shift of each dimension; `latin_hypercube`: one sample in each of n_samples equal intervals of
/// each dimension.
Eigen::MatrixXd unit_samples(job::SampleSequence sequence, Eigen::Index n_samples, Eigen::Index n_dimensions,
                             std::uint32_t seed);

// Statistics of samples: quantiles, rank correlation, and first-order Sobol indices from given samples.

/// Quantile of the finite values, linear between order statistics (type 7 of Hyndman and Fan, 1996, Am Stat
/// 50:361); NaN without any. 0: smallest, 1: largest.
double quantile(std::vector<double> values, double probability);

/// Spearman's rank correlation of the pairs of finite numbers, ties by mean rank; NaN with fewer than 3 pairs
/// or without spread.
double rank_correlation(std::span<const double> x, std::span<const double> y);

/// Share of the variance of a result that one input explains alone, and its 90 % interval, both within 0 and
/// 1; NaN with fewer than 40 samples or without spread.
struct FirstOrderIndex {
  double index = 0.0, low = 0.0, high = 0.0;
};

/// First-order Sobol indices of one input for many results. The conditional mean of a result is a polynomial
/// of the input's score (Hermite, to degree 3): its adjusted coefficient of determination is the index
/// (polynomial chaos of one variable; Sudret, 2008, Reliab Eng Syst Saf 93:964). The interval is the
/// index +- 1.645 times its standard error by the jackknife over 20 groups of samples.
/// `scores` [n]: standard normal; `results` [n, m]: rows with a number that is not finite are left out.
/// `group` [n]: from 0 to n_jackknife_groups - 1, at random.
std::vector<FirstOrderIndex> first_order_indices(const Eigen::VectorXd& scores,
                                                 const Eigen::MatrixXd& results,
                                                 const std::vector<int>& group);
inline constexpr int n_jackknife_groups = 20;

/// Groups of equal size in random order.
std::vector<int> jackknife_groups(std::size_t n, std::uint32_t seed);

}  // namespace vrda::job
