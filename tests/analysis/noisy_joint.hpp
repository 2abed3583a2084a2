/// Motion models whose surfaces are polynomials of a known degree, with seeded noise.
#pragma once

#include <random>

#include "store/motion_model.hpp"

namespace vrda::test {

/// Standard normal numbers, equal on all platforms (Marsaglia's polar method); the standard library's differ.
class NormalNumbers {
 public:
  explicit NormalNumbers(unsigned seed) : generator_(seed) {}
  double next();
  /// Uniform in [-1, 1).
  double next_uniform();

 private:
  std::mt19937_64 generator_;
};

struct NoisyJoint {
  int degree = 2;         ///< of all four surfaces
  double noise_mm = 0.0;  ///< standard deviation; for theta in degrees
  /// Size of each coefficient of the highest total degree, in its standard errors under that noise (0.01 if
  /// the noise is 0); signs are random.
  double significance = 10.0;
  /// Lower terms P_p(flexion) P_q(varus) are random within +- lower_mm / (1 + p^2): a higher one within 60
  /// degrees would be a visibly rough motion.
  double lower_mm = 2.0;
  int n_flexion = 21, n_varus = 13;  ///< solved everywhere; 3 degrees by 1
  unsigned seed = 1;
};

/// Surfaces, status and push; no bodies.
store::MotionModel noisy_model(const NoisyJoint& joint);

}  // namespace vrda::test
