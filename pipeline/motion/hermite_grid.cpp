#include "motion/hermite_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vrda {
namespace {

/// Values along one grid line.
struct Line {
  const std::vector<double>& at;
  std::vector<double> value;
  std::vector<bool> is_solved;
};

/// Slope at node k towards the side `step` (+1 or -1), from that side's nodes alone.
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

/// Fills `slope_field` with the slopes of `value_field` along grid lines of `at`, whose nodes lie
/// `stride` apart from `first` on.
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

/// Part of a step: far below any angle that is measured, far above rounding.
constexpr double on_node = 1e-9;

/// One angle's part of a patch: Hermite weights of the values and slopes at its two ends.
struct Span {
  std::size_t first = 0;
  std::array<double, 2> value{1.0, 0.0};
  std::array<double, 2> slope{0.0, 0.0};  ///< rad
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
  // So near a node it is meant: 0.1 added three times must not ask the cell beyond 0.3.
  if (std::abs(s) < on_node) s = 0.0;
  if (std::abs(1.0 - s) < on_node) s = 1.0;
  const double r = 1.0 - s;
  span.value = {r * r * (1.0 + 2.0 * s), s * s * (1.0 + 2.0 * r)};
  span.slope = {h * s * r * r, -h * r * s * s};
  return span;
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
  for (std::size_t a = 0; a < 2; ++a) {
    if (flexion.value[a] == 0.0) continue;  // on a node the far end of the patch does not matter
    for (std::size_t b = 0; b < 2; ++b) {
      if (varus.value[b] == 0.0) continue;
      const HermiteNode<N>& node = grid.nodes[(flexion.first + a) * grid.varus_rad.size() + varus.first + b];
      if (!node.is_solved) return result;
      for (std::size_t number = 0; number < N; ++number) {
        result.numbers[number] += flexion.value[a] * varus.value[b] * node.value[number] +
                                  flexion.slope[a] * varus.value[b] * node.by_flexion[number] +
                                  flexion.value[a] * varus.slope[b] * node.by_varus[number] +
                                  flexion.slope[a] * varus.slope[b] * node.by_both[number];
      }
    }
  }
  result.is_solved = true;
  return result;
}

template void set_slopes(HermiteGrid<1>&);
template void set_slopes(HermiteGrid<4>&);
template void set_slopes(HermiteGrid<5>&);
template HermiteSample<1> sample(const HermiteGrid<1>&, const Attitude&);
template HermiteSample<4> sample(const HermiteGrid<4>&, const Attitude&);
template HermiteSample<5> sample(const HermiteGrid<5>&, const Attitude&);

}  // namespace vrda
