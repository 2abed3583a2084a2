/// A small valid motion model, computed by formulas.
#pragma once

#include <cstdint>

#include "store/motion_model.hpp"

namespace vrda::test {

struct SampleOptions {
  std::int32_t n_flexion = 4;
  std::int32_t n_varus = 3;
  bool has_compartments = true;
  bool has_visual = true;
  bool has_failed_cell = true;  ///< cell (1, 2) ended as no_clearance
  bool is_equilibrium = false;  ///< method equilibrium, with a Delta that rotates over flexion
  std::int32_t n_fibres = 0;    ///< 0: no ligaments
  std::int32_t n_wraps = 0;     ///< only with fibres
  bool has_frames = false;      ///< a sequence of frames: flexion rises and falls; n_varus is 1
};

/// Balls for bodies, two contacts per solved cell, one smoothed set of degree 1. As an equilibrium, a medial
/// and a lateral force in every solved cell with an even index, none in the others.
store::MotionModel sample_model(const SampleOptions& options = {});

}  // namespace vrda::test
