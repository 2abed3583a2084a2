/// Random numbers that depend on what they are for, not on how many were drawn before.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace vrda {

/// What numbers are drawn for.
enum class DrawFor : std::uint64_t { frame, potentiometer, virtual_bench, virtual_hand, virtual_tracker };

class Draws {
 public:
  /// The same numbers for the same seed, purpose and index.
  Draws(std::uint64_t seed, DrawFor purpose, std::uint64_t index);
  /// In [0, 1), 53 bits.
  double uniform();
  /// Mean 0, variance 1, within 6 of them: the sum of twelve uniform numbers, which needs no logarithm and
  /// has the same bits everywhere.
  double normal();
  Eigen::Vector3d normal_vector();

 private:
  std::mt19937_64 bits_;
};

}  // namespace vrda
