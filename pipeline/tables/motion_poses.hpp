/// From a table to the poses of a joint.
#pragma once

#include <string>
#include <vector>

#include "tables/motion_convention.hpp"
#include "tables/motion_table.hpp"

namespace vrda::tables {

/// A measured motion: one pose per frame.
struct MotionSequence {
  std::string key_name;                          ///< as store::FrameSequence
  std::vector<double> key;                       ///< [n] strictly ascending
  std::vector<Pose> X_reference_moving;          ///< [n] canonical, stored vertices, as in a motion model
  std::vector<std::string> absent_columns = {};  ///< as MotionTable
  std::vector<std::string> warnings = {};        ///< one line each: of the table, and unit_warnings()
};

/// The poses of the table's frames under `convention`. Throws InputError naming file and line for a matrix
/// that is not a rotation within 0.01 per element of R^T R, or mirrors, and for a position beyond 1e9 mm.
std::vector<Pose> poses_of(const MotionTable& table, const Convention& convention, const JointFrame& joint);

/// Reads a motion. What neither `convention` nor the file states has the default of Convention. Throws
/// InputError as read_motion_table(), unit_warnings() and poses_of().
MotionSequence read_motion(const std::string& file, const MotionConvention& convention = {});

}  // namespace vrda::tables
