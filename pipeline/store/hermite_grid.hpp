/// Bicubic Hermite interpolation of values at the nodes of an attitude grid.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "model/frames.hpp"

namespace vrda::store {

/// One node with its slopes; all zero if it is unsolved.
template <std::size_t N>
struct HermiteNode {
  std::array<double, N> value{};       ///< mm, rad
  std::array<double, N> by_flexion{};  ///< derivative by flexion, per radian
  std::array<double, N> by_varus{};    ///< derivative by varus, per radian
  std::array<double, N> by_both{};     ///< mixed derivative, per radian squared
  bool is_solved = false;
};

/// N surfaces over one grid: 4 (pose), 1 (travel), 5 (pose and varus) or 6 (and flexion).
template <std::size_t N>
struct HermiteGrid {
  std::vector<double> flexion_rad;    ///< [n_flexion] ascending
  std::vector<double> varus_rad;      ///< [n_varus] ascending
  std::vector<HermiteNode<N>> nodes;  ///< [n_flexion * n_varus], varus runs fastest
};

/// Sets the slopes at the nodes from the parabola through a node and its solved neighbours: central with two
/// neighbours, one-sided next to a hole or an end, the chord with a single neighbour.
template <std::size_t N>
void set_slopes(HermiteGrid<N>& grid);

template <std::size_t N>
struct HermiteSample {
  std::array<double, N> values{};
  bool is_solved = false;  ///< false if a corner of the patch is unsolved; the numbers are then invalid
};

/// `attitude` must be within the axes. Exact at the nodes; allocates nothing.
template <std::size_t N>
HermiteSample<N> sample(const HermiteGrid<N>& grid, const Attitude& attitude);

}  // namespace vrda::store
