/// Synthetic marks of fits: noise, coverage of confidence intervals, a knee.
#pragma once

#include <cstdint>
#include <random>

#include "calibration/functional_fit.hpp"

namespace vrda::test {

/// Counts how often intervals contain the true value.
class Coverage {
 public:
  /// `error`: estimated minus true value of each number, or of the first ones.
  void add(const bench::Estimate& estimate, const Eigen::VectorXd& error);
  void add(const std::string& name, double error, double half_width);
  /// Expects each number within its 95 % interval in 90 to 98 % of cases, which holds for correct intervals
  /// in 97 % of runs of 200 cases. Numbers of the left and the right eye are pooled.
  void expect_honest() const;

 private:
  struct Count {
    int n = 0, n_within = 0;
  };
  std::map<std::string, Count> counts_;
};

/// Pose error as in Estimate: translation in mm and rotation vector about the fixed axes in deg.
Eigen::VectorXd place_error(const Pose& X_found, const Pose& X_true);

/// Portable normal noise: sums of twelve uniform numbers, mean 0, variance 1.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : bits_(seed) {}
  double uniform();  ///< in [0, 1)
  double normal();
  Eigen::VectorXd normals(Eigen::Index n);

 private:
  std::mt19937_64 bits_;
};

/// A knee that rolls back by 12 mm, turns inwards by 15 degrees and tilts by 3 while it bends by 90.
calibration::JointCurve knee_curve();

}  // namespace vrda::test
