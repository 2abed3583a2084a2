/// The surfaces of a motion model, raw and smoothed.
#pragma once

#include <array>
#include <vector>

#include "store/hermite_grid.hpp"
#include "store/evaluate_smoothed.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

/// x, y, z of the moving object in world W (mm), and theta (rad, right-knee sign).
using PoseCoordinates = std::array<double, 4>;
/// The same, then varus (rad).
using PoseAndVarus = std::array<double, 5>;

using RawNode = HermiteNode<4>;
using RawSurfaces = HermiteGrid<4>;
using RawSample = HermiteSample<4>;

RawSurfaces raw_surfaces(const store::MotionModel& model);

/// One basis polynomial of a smoothed set with its coefficient in every surface.
struct SmoothedTerm {
  int flexion_degree = 0;
  int varus_degree = 0;
  PoseAndVarus coefficient{};  ///< mm, rad
};

/// Sum of coefficient P_i(u) P_j(v) as in store/evaluate_smoothed.hpp, for all surfaces in one pass.
struct SmoothedSurfaces {
  store::AxisRanges ranges;
  int degree = 0;          ///< highest exponent
  bool has_varus = false;  ///< varus was free and has a surface; if false its coefficients are 0
  std::vector<SmoothedTerm> terms;
};

SmoothedSurfaces smoothed_surfaces(const store::MotionModel& model, const store::SmoothedSet& set);

/// Value at `attitude`, which should be within the axes. Allocates nothing.
PoseAndVarus evaluate(const SmoothedSurfaces& surfaces, const Attitude& attitude);

}  // namespace vrda::store
