/// The BlockFunctions for a vector type F of F::width floats.
#pragma once

#include "proximity/gap_place_lanes.hpp"
#include "proximity/gap_test_lanes.hpp"

namespace vrda {

template <typename F>
constexpr BlockFunctions block_functions()
{
  using Place = PlaceLanes<F>;
  using Test = TestLanes<F>;
  return {Place::turn_inner, Place::turn_leaf, Place::place_inner, Place::place_leaf, Test::reference_near,
          Test::moving_near, Test::test,       Test::test_ahead,   Test::screen};
}

}  // namespace vrda
