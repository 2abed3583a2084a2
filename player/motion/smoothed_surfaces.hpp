/// One smoothed set of a motion model, its four surfaces evaluated in one pass.
#pragma once

#include <vector>

#include "motion/raw_surfaces.hpp"

namespace vrda {

/// Terms up to this total degree are evaluated on the stack; `compare` goes to 12.
inline constexpr int highest_smoothed_degree = 16;

struct SmoothedTerm {
  int flexion_degree = 0;
  int varus_degree = 0;
  PoseNumbers coefficient{};  ///< mm, rad
};

/// Sum of coefficient P_i(u) P_j(v), Legendre polynomials, u and v on [-1, 1] over the axes.
struct SmoothedSurfaces {
  double first_flexion_rad = 0.0, last_flexion_rad = 0.0;
  double first_varus_rad = 0.0, last_varus_rad = 0.0;
  std::vector<SmoothedTerm> terms;
};

SmoothedSurfaces smoothed_surfaces(const MotionModel& model, const SmoothedSet& set);

/// Value at `attitude`, which should lie within the axes. Allocates nothing.
PoseNumbers evaluate(const SmoothedSurfaces& surfaces, const Attitude& attitude);

}  // namespace vrda
