/// A small motion model that follows the specification, made by formulas.
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
  bool is_equilibrium = false;  ///< by that method, with a Delta that turns over flexion
  std::int32_t n_fibres = 0;    ///< 0: no ligaments
  std::int32_t n_wraps = 0;     ///< only with fibres
};

/// Balls for bodies, two contacts a solved cell, one smoothed set of degree 1. As an equilibrium, a medial
/// and a lateral force in every solved cell of even number, none in the others.
MotionModel sample_model(const SampleOptions& options = {});

}  // namespace vrda::test
