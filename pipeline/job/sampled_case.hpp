/// The case of each sample: draws of the uncertain inputs applied to the case of the job.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "job/uncertainty.hpp"

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

 private:
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

}  // namespace vrda::job
