/// Second differences of a sequence of poses, and the weight of their squares that follows from the noise.
#pragma once

#include <array>
#include <vector>

#include "analysis/pose_path.hpp"

namespace vrda::analysis {

/// Second difference about frame `frame`, in units of the noise per squared mean spacing of the key, and its
/// derivatives over the twists of the frame before, of the frame and of the one after it.
struct SecondDifference {
  std::size_t frame = 0;
  Vector6d value = Vector6d::Zero();
  std::array<Matrix6d, 3> jacobian{};
};

/// Of the first differences of the poses: rotation vectors from one frame to the next, in S, and
/// displacements of the origin. Empty below three frames. `twist` are those of displaced() that gave `X`.
std::vector<SecondDifference> second_differences(const std::vector<double>& key, const std::vector<Pose>& X,
                                                 const std::vector<Vector6d>& twist, const NoiseScale& scale);

/// Weight of the squared second differences of each coordinate that minimises the expected squared error of
/// the smoothed measurement, estimated without knowing the truth: residual + 2 trace (Mallows' C_p; Craven
/// and Wahba (1979) Numer Math 31:377-403, eq. 1.9). Powers of 2; 0 for an exact coordinate and below three
/// frames.
Vector6d weights_from_noise(const std::vector<double>& key, const std::vector<Pose>& X_measured,
                            const NoiseScale& scale);

/// The weight at which an oscillation of this period (in mean spacings of the key, above 2) keeps half its
/// amplitude, and the inverse: 2 for weights that do so at no period, infinite where none passes.
double weight_of_period(double period_frames);
double period_of_weight(double weight);

}  // namespace vrda::analysis
