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
};

/// Balls for bodies, two contacts a solved cell, one smoothed set of degree 1.
MotionModel sample_model(const SampleOptions& options = {});

}  // namespace vrda::test
