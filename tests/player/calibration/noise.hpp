/// Noise for synthetic marks, and how often stated intervals hold the truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

#include "calibration/estimate.hpp"

namespace vrda::test {

/// The same numbers on every machine: sums of twelve uniform numbers, mean 0, variance 1.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : bits_(seed) {}
  double uniform();  ///< in [0, 1)
  double normal();
  Eigen::VectorXd normals(Eigen::Index n);
  /// Of mean 0 and that covariance, positive definite.
  Eigen::VectorXd correlated(const Eigen::MatrixXd& covariance);

 private:
  std::mt19937_64 bits_;
};

/// For each number of many estimates: how many of their 95 % intervals hold it.
class Coverage {
 public:
  void add(const Estimate& estimate, const Eigen::VectorXd& errors);
  int n() const { return n_; }
  /// Parts of 1.
  double of(Eigen::Index number) const;
  Eigen::Index size() const { return within_.size(); }

 private:
  int n_ = 0;
  Eigen::VectorXi within_;
};

}  // namespace vrda::test
