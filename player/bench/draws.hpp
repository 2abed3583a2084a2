/// Random numbers seeded by purpose and index, independent of how many were drawn before.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace vrda::bench {

/// Purpose of a random sequence.
enum class RandomPurpose : std::uint64_t {
  frame,
  potentiometer,
  virtual_bench,
  virtual_hand,
  virtual_tracker
};

class RandomSequence {
 public:
  /// Equal seed, purpose and index give an equal sequence.
  RandomSequence(std::uint64_t seed, RandomPurpose purpose, std::uint64_t index);
  /// In [0, 1), 53 bits.
  double uniform();
  /// Mean 0, variance 1, within +-6: the sum of twelve uniform numbers minus 6, with identical bits on
  /// every processor, since no logarithm is used.
  double normal();
  Eigen::Vector3d normal_vector();

 private:
  std::mt19937_64 bits_;
};

}  // namespace vrda::bench
