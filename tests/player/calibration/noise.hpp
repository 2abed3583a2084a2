/// Noise for synthetic marks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace vrda::test {

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

}  // namespace vrda::test
