/// The BlockFunctions for a vector type F of F::width floats.
#pragma once

#include "proximity/gap_pair_lanes.hpp"
#include "proximity/gap_place_lanes.hpp"
#include "proximity/gap_test_lanes.hpp"

namespace vrda::proximity {

template <typename F>
constexpr BlockFunctions block_functions()
{
  using P = PlaceLanes<F>;
  using T = TestLanes<F>;
  return {P::rotate_inner, P::rotate_leaf, P::place_inner, P::place_leaf, T::reference_near, T::moving_near,
          T::test,         T::test_ahead,  T::screen,      screen_pairs,  screen_apart};
}

}  // namespace vrda::proximity
