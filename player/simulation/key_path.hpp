/// Interpolation of key values over time.
#pragma once

#include <vector>

namespace vrda::simulation {

struct PathPoint {
  double time_s = 0.0;
  double value = 0.0;
};

/// Monotone piecewise cubic with continuous slope: never leaves the range of the neighbouring keys; the
/// slope is 0 at extrema. Source: Fritsch and Butland (1984) SIAM J Sci Stat Comput 5:300-304.
class KeyPath {
 public:
  /// One point or more, ascending in time. If looped, the last value must equal the first; otherwise the
  /// end values are held.
  KeyPath(std::vector<PathPoint> points, bool is_looped);
  double at(double time_s) const;

 private:
  std::vector<PathPoint> points_;
  std::vector<double> slopes_;  ///< per second
  bool is_looped_ = false;
};

}  // namespace vrda::simulation
