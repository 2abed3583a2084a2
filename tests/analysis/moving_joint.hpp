/// A smooth motion with known coordinates, for the tests of this folder.
#pragma once

#include <vector>

#include "analysis/score.hpp"
#include "core/units.hpp"

namespace vrda::test {

/// Coordinates of frame k of n: all six vary, over one cycle.
inline analysis::Coordinates moving_coordinates(int k, int n)
{
  const double phase = 2.0 * pi * k / n;
  return {0.5 + 0.4 * sine(phase),       0.06 * sine(2 * phase + 0.3), 0.15 * cosine(phase + 0.7),
          4.0 * sine(phase + 1.0) + 1.0, 2.0 * cosine(3 * phase),      1.5 * sine(phase) - 0.5};
}

/// A motion of n frames as rows, with keys 0, 1, ...
inline analysis::Sequence moving_sequence(int n)
{
  analysis::Sequence sequence{"measured.csv", "frame", {}, {}};
  for (int k = 0; k < n; ++k) {
    sequence.key.push_back(k);
    sequence.rows.push_back({moving_coordinates(k, n)});
  }
  return sequence;
}

/// A rigid transform with a rotation about no axis of the frame.
inline Pose rigid_transform(double x_rad, double y_rad, double z_rad, const Eigen::Vector3d& shift_mm)
{
  Pose X = Pose::Identity();
  X.linear() = rotation_x(x_rad) * rotation_y(y_rad) * rotation_z(z_rad);
  X.translation() = shift_mm;
  return X;
}

}  // namespace vrda::test
