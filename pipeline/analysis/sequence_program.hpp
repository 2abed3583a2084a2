/// Convex quadratic programme over a sequence of frames: neighbours coupled up to two frames apart, linear
/// bounds within a frame.
#pragma once

#include <array>
#include <vector>

#include "analysis/pose_path.hpp"

namespace vrda::analysis {

/// normal . x >= offset for the six unknowns of one frame.
struct FrameBound {
  Vector6d normal;
  double offset = 0.0;
};

/// Minimise x^T H x / 2 - b^T x subject to the bounds. H is I plus a positive semidefinite matrix.
struct SequenceProgram {
  /// [n_frames] blocks of H: row k, columns k, k - 1 and k - 2.
  std::vector<std::array<Matrix6d, 3>> H;
  std::vector<Vector6d> b;                      ///< [n_frames]
  std::vector<std::vector<FrameBound>> bounds;  ///< [n_frames]
};

/// The minimum; where bounds contradict each other, a point between them. The excess over bounds that can be
/// met is below 1e-6 of the unknowns' unit. Augmented Lagrangian with a semismooth Newton method: every
/// linear system has the band of H. Source: Hintermueller, Ito and Kunisch (2002) SIAM J Optim 13:865-888.
std::vector<Vector6d> minimise(const SequenceProgram& program);

}  // namespace vrda::analysis
