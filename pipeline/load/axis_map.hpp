/// From the coordinates of the mesh files to canonical axes (DESIGN.md 3).
#pragma once

#include "load/job.hpp"

namespace vrda {

/// p_canonical = rotation * (unit_mm * p_native) + translation_mm. Order: the unit is scaled to mm, the
/// alignment is applied in the files' own axes (R = Rz Ry Rx about their fixed axes, then the
/// translation), then axes are renamed: X anterior, Y proximal, Z the subject's right.
struct AxisMap {
  double unit_mm = 1.0;
  Pose X_canonical_native = Pose::Identity();

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_native) const
  {
    return X_canonical_native * (unit_mm * p_native);
  }
};

/// 1, 10 or 1000 for "mm", "cm" and "m".
double mm_in(const std::string& unit);

/// Throws InputError when two words name the same axis or the three make a left-handed map.
AxisMap axis_map(const Job& job);

}  // namespace vrda
