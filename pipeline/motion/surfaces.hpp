/// The surfaces of a motion model, raw and smoothed.
#pragma once

#include <array>
#include <vector>

#include "motion/hermite_grid.hpp"
#include "store/evaluate_smoothed.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// x, y, z of the moving object in world W (mm), and theta (rad, right-knee sign).
using PoseNumbers = std::array<double, 4>;
/// The same, then the varus it stands at (rad).
using PoseAndVarus = std::array<double, 5>;

using RawNode = HermiteNode<4>;
using RawSurfaces = HermiteGrid<4>;
using RawSample = HermiteSample<4>;

RawSurfaces raw_surfaces(const MotionModel& model);

/// One smoothed set of a motion model, its surfaces evaluated in one pass.
struct SmoothedTerm {
  int flexion_degree = 0;
  int varus_degree = 0;
  PoseAndVarus coefficient{};  ///< mm, rad
};

/// Sum of coefficient P_i(u) P_j(v) as in store/evaluate_smoothed.hpp, the terms of all surfaces side by
/// side.
struct SmoothedSurfaces {
  AxisRanges ranges;
  int degree = 0;          ///< highest of any exponent
  bool has_varus = false;  ///< varus was free and has a surface; otherwise its coefficients are 0
  std::vector<SmoothedTerm> terms;
};

SmoothedSurfaces smoothed_surfaces(const MotionModel& model, const SmoothedSet& set);

/// Value at `attitude`, which should lie within the axes. Allocates nothing.
PoseAndVarus evaluate(const SmoothedSurfaces& surfaces, const Attitude& attitude);

/// The value, as evaluate() gives it, with its derivatives, a radian of each angle; 0 by an angle whose axis
/// has one value.
struct SmoothedRate {
  PoseAndVarus here{};
  PoseAndVarus by_flexion{};
  PoseAndVarus by_varus{};
};
SmoothedRate evaluate_rate(const SmoothedSurfaces& surfaces, const Attitude& attitude);

}  // namespace vrda
