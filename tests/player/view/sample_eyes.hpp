/// Sample eyes of simulated benches.
#pragma once

#include "view/eye.hpp"

namespace vrda::test {

/// The right eye of the thesis's layout: the lower right quarter, with a smaller, off-centre visible part.
view::Eye sample_eye(double k1 = 0.12, double k2 = 0.02);

struct Optics {
  double k1, k2;
};
inline constexpr Optics lenses[] = {{0.0, 0.0}, {0.12, 0.02}, {0.25, 0.0}, {-0.1, 0.01}};

}  // namespace vrda::test
