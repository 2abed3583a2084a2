/// From the coordinates of the mesh files to canonical axes (schemas/frames.md).
#pragma once

#include "job/job.hpp"

namespace vrda::job {

/// p_canonical = X_canonical_native * (unit_mm * p_native). Order: conversion to mm; alignment in the files'
/// axes (R = Rz Ry Rx about fixed axes, then the translation); renaming of the axes (X anterior, Y proximal,
/// Z to the subject's right).
struct AxisMap {
  double unit_mm = 1.0;
  Pose X_canonical_native = Pose::Identity();

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_native) const
  {
    return X_canonical_native * (unit_mm * p_native);
  }
};

/// 1, 10 or 1000 for "mm", "cm" and "m".
double mm_per_unit(const std::string& unit);
/// "mm", "cm" or "m", the unit of 1, 10 or 1000 mm.
const char* unit_of_mm(double mm);

/// The map of [frame]. Throws InputError if two directions name the same axis or the map is left-handed.
AxisMap axis_map(const Job& job);

/// The map of a body's files: that of [frame], or with a frame of its own: unit and alignment about its
/// origin, which goes to the rotation centre of the job, axes, then the translation.
AxisMap body_map(const Job& job, const BodyJob& body);
struct BodyMaps {
  AxisMap reference, moving;
};
BodyMaps body_maps(const Job& job);

}  // namespace vrda::job
