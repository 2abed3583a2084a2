#include "store/hermite_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vrda::store {
namespace {

/// Values along one grid line.
struct Line {
  const std::vector<double>& at;
  std::vector<double> value;
  std::vector<bool> is_solved;
};

/// One-sided slope at node k from the nodes on side `step` (+1 or -1).
double one_sided_slope(const Line& line, std::ptrdiff_t k, std::ptrdiff_t step)
{
  const auto value = [&](std::ptrdiff_t i) { return line.value[static_cast<std::size_t>(i)]; };
  const auto at = [&](std::ptrdiff_t i) { return line.at[static_cast<std::size_t>(i)]; };
  const auto n = static_cast<std::ptrdiff_t>(line.at.size());
  const double chord = (value(k + step) - value(k)) / (at(k + step) - at(k));
  const std::ptrdiff_t far = k + 2 * step;
  if (far < 0 || far >= n || !line.is_solved[static_cast<std::size_t>(far)]) return chord;
  const double next_chord = (value(far) - value(k + step)) / (at(far) - at(k + step));
  return chord - (at(k + step) - at(k)) * (next_chord - chord) / (at(far) - at(k));
}

double slope(const Line& line, std::ptrdiff_t k)
{
  const auto n = static_cast<std::ptrdiff_t>(line.at.size());
  const auto i = static_cast<std::size_t>(k);
  if (!line.is_solved[i]) return 0.0;
  const bool has_before = k > 0 && line.is_solved[i - 1];
  const bool has_after = k + 1 < n && line.is_solved[i + 1];
  if (has_before && has_after) {
    const double h_before = line.at[i] - line.at[i - 1], h_after = line.at[i + 1] - line.at[i];
    const double before = (line.value[i] - line.value[i - 1]) / h_before;
    const double after = (line.value[i + 1] - line.value[i]) / h_after;
    return (before * h_after + after * h_before) / (h_before + h_after);
  }
  if (has_after) return one_sided_slope(line, k, 1);
  if (has_before) return one_sided_slope(line, k, -1);
  return 0.0;
}

template <std::size_t N>
using Field = std::array<double, N> HermiteNode<N>::*;

/// Sets `slope_field` to the slopes of `value_field` along a grid line with coordinates `at`: nodes `first`,
/// `first + stride`, ...
template <std::size_t N>
void fill_slopes(HermiteGrid<N>& grid, const std::vector<double>& at, std::size_t first, std::size_t stride,
                 std::pair<Field<N>, Field<N>> value_and_slope)
{
  const auto [value_field, slope_field] = value_and_slope;
  for (std::size_t number = 0; number < N; ++number) {
    Line line{at, {}, {}};
    for (std::size_t k = 0; k < at.size(); ++k) {
      const HermiteNode<N>& node = grid.nodes[first + k * stride];
      line.value.push_back((node.*value_field)[number]);
      line.is_solved.push_back(node.is_solved);
    }
    for (std::size_t k = 0; k < at.size(); ++k) {
      (grid.nodes[first + k * stride].*slope_field)[number] = slope(line, static_cast<std::ptrdiff_t>(k));
    }
  }
}

/// Fraction of a step: far below any measured angle, far above rounding.
constexpr double on_node = 1e-9;

/// Hermite weights of the values and slopes at the two ends of a patch, along one angle.
struct Weights {
  std::array<double, 2> value{};
  std::array<double, 2> slope{};
};

/// One angle's part of a patch.
struct Span {
  std::size_t first = 0;
  double step_rad = 0.0;    ///< 0 where the axis has one value
  double s = 0.0, r = 1.0;  ///< fraction of the step from the first end, and from the second
  Weights weights{{1.0, 0.0}, {0.0, 0.0}};
};

Span span_of(const std::vector<double>& at, double x)
{
  Span span;
  if (at.size() == 1) return span;
  const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, x);
  span.first = static_cast<std::size_t>(above - at.begin()) - 1;
  const double h = at[span.first + 1] - at[span.first];
  // Divided, not multiplied by 1/h: s is exactly 1 at the last node.
  double s = (x - at[span.first]) / h;
  // Snaps to a nearby node: 0.1 added three times must not use the cell beyond 0.3.
  if (std::abs(s) < on_node) s = 0.0;
  if (std::abs(1.0 - s) < on_node) s = 1.0;
  const double r = 1.0 - s;
  span.step_rad = h;
  span.s = s;
  span.r = r;
  span.weights = {{r * r * (1.0 + 2.0 * s), s * s * (1.0 + 2.0 * r)}, {h * s * r * r, -h * r * s * s}};
  return span;
}

/// Adds the contribution of a node to every surface.
template <std::size_t N>
void add(std::array<double, N>& sums, const HermiteNode<N>& node, const std::array<double, 4>& weights)
{
  for (std::size_t number = 0; number < N; ++number) {
    sums[number] += weights[0] * node.value[number] + weights[1] * node.by_flexion[number] +
                    weights[2] * node.by_varus[number] + weights[3] * node.by_both[number];
  }
}

/// Weights of a node's value and slopes, at end `a` of the patch along flexion and `b` along varus.
std::array<double, 4> product(const Weights& flexion, std::size_t a, const Weights& varus, std::size_t b)
{
  return {flexion.value[a] * varus.value[b], flexion.slope[a] * varus.value[b],
          flexion.value[a] * varus.slope[b], flexion.slope[a] * varus.slope[b]};
}

/// Calls use(node, a, b) for the corners of a patch with nonzero weight until one call returns false; returns
/// whether all returned true.
template <std::size_t N, typename Use>
bool for_corners(const HermiteGrid<N>& grid, const Span& flexion, const Span& varus, const Use& use)
{
  for (std::size_t a = 0; a < 2; ++a) {
    if (flexion.weights.value[a] == 0.0) continue;  // on a node the far end of the patch has no weight
    for (std::size_t b = 0; b < 2; ++b) {
      if (varus.weights.value[b] == 0.0) continue;
      if (!use(grid.nodes[(flexion.first + a) * grid.varus_rad.size() + varus.first + b], a, b)) return false;
    }
  }
  return true;
}

}  // namespace

template <std::size_t N>
void set_slopes(HermiteGrid<N>& grid)
{
  using Node = HermiteNode<N>;
  const std::size_t n_flexion = grid.flexion_rad.size(), n_varus = grid.varus_rad.size();
  for (std::size_t j = 0; j < n_varus; ++j) {
    fill_slopes<N>(grid, grid.flexion_rad, j, n_varus, {&Node::value, &Node::by_flexion});
  }
  for (std::size_t i = 0; i < n_flexion; ++i) {
    fill_slopes<N>(grid, grid.varus_rad, i * n_varus, 1, {&Node::value, &Node::by_varus});
    fill_slopes<N>(grid, grid.varus_rad, i * n_varus, 1, {&Node::by_flexion, &Node::by_both});
  }
}

template <std::size_t N>
HermiteSample<N> sample(const HermiteGrid<N>& grid, const Attitude& attitude)
{
  const Span flexion = span_of(grid.flexion_rad, attitude.flexion_rad);
  const Span varus = span_of(grid.varus_rad, attitude.varus_rad);
  HermiteSample<N> result;
  result.is_solved =
      for_corners(grid, flexion, varus, [&](const HermiteNode<N>& node, std::size_t a, std::size_t b) {
        if (node.is_solved) add(result.values, node, product(flexion.weights, a, varus.weights, b));
        return node.is_solved;
      });
  return result;
}

template void set_slopes(HermiteGrid<1>&);
template void set_slopes(HermiteGrid<4>&);
template void set_slopes(HermiteGrid<5>&);
template void set_slopes(HermiteGrid<6>&);
template HermiteSample<1> sample(const HermiteGrid<1>&, const Attitude&);
template HermiteSample<4> sample(const HermiteGrid<4>&, const Attitude&);
template HermiteSample<5> sample(const HermiteGrid<5>&, const Attitude&);
template HermiteSample<6> sample(const HermiteGrid<6>&, const Attitude&);

}  // namespace vrda::store
