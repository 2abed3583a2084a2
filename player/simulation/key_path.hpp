/// A smooth way through key values.
#pragma once

#include <vector>

namespace vrda {

struct PathPoint {
  double time_s = 0.0;
  double value = 0.0;
};

/// Cubic pieces with a continuous slope that never leave the range of the keys at their ends: at a turning
/// point the slope is 0. Source: Fritsch and Butland (1984) SIAM J Sci Stat Comput 5:300-304.
class KeyPath {
 public:
  /// One point or more, by time. Looped: the last follows on the first and must have its value; otherwise
  /// both ends are held.
  KeyPath(std::vector<PathPoint> points, bool is_looped);
  double at(double time_s) const;

 private:
  std::vector<PathPoint> points_;
  std::vector<double> slopes_;  ///< a second
  bool is_looped_ = false;
};

}  // namespace vrda
