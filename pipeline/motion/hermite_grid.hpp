/// Values at the nodes of a grid of attitudes, joined by bicubic Hermite patches.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/frames.hpp"

namespace vrda {

/// One node with its slopes; all zero where it is not solved.
template <std::size_t N>
struct HermiteNode {
  std::array<double, N> value{};       ///< mm, rad
  std::array<double, N> by_flexion{};  ///< derivative by flexion, a radian
  std::array<double, N> by_varus{};    ///< derivative by varus, a radian
  std::array<double, N> by_both{};     ///< mixed derivative, a radian squared
  bool is_solved = false;
};

/// N surfaces over one grid. N is 4 (a pose), 1 (a travel) or 5 (a pose and its varus).
template <std::size_t N>
struct HermiteGrid {
  std::vector<double> flexion_rad;    ///< [n_flexion] ascending
  std::vector<double> varus_rad;      ///< [n_varus] ascending
  std::vector<HermiteNode<N>> nodes;  ///< [n_flexion * n_varus], varus runs fastest
};

/// Fills in the slopes at the nodes from their values. They come from the parabola through a node and its
/// solved neighbours: central where both stand, one-sided beside a hole or an end, the chord where only one
/// is left.
template <std::size_t N>
void set_slopes(HermiteGrid<N>& grid);

template <std::size_t N>
struct HermiteSample {
  std::array<double, N> numbers{};
  bool is_solved = false;  ///< false where a corner of the patch is unsolved; numbers mean nothing then
};

/// `attitude` must lie within the axes. Exact at the nodes; allocates nothing.
template <std::size_t N>
HermiteSample<N> sample(const HermiteGrid<N>& grid, const Attitude& attitude);

/// A sample with its derivatives, a radian of each angle; 0 by an angle whose axis has one value. At an end
/// of an axis the one-sided derivative.
template <std::size_t N>
struct HermiteRate {
  HermiteSample<N> here;
  std::array<double, N> by_flexion{};
  std::array<double, N> by_varus{};
};

/// As sample(), with the same bits.
template <std::size_t N>
HermiteRate<N> sample_rate(const HermiteGrid<N>& grid, const Attitude& attitude);

}  // namespace vrda
