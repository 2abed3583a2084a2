/// A pose of the joint where its scan is, for programs that show both (schemas/slicer.md).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "store/motion_model.hpp"
#include "tables/tables.hpp"

namespace vrda::tables {

struct ScanFrame {
  Pose X_scan_reference = Pose::Identity();  ///< mm
  double unit_mm = 1.0;                      ///< of the scan's files
  std::string space;                         ///< LPS, RAS, or empty: the files do not say
};

/// Where the mesh files of the reference lie: [scan] of a prepared job, else the frame of the job. Throws
/// InputError naming `file` for a model without a job, and one with [scaling], whose bones are not the
/// scan's.
ScanFrame scan_frame(const store::MotionModel& model, const std::string& file);

/// Each body at the pose, with its name; the reference is where the scan has it. Axes and unit of the scan.
std::vector<std::pair<std::string, Mesh>> meshes_in_scan(const store::MotionModel& model,
                                                         const FlexionFrame& frame, const ScanFrame& scan);

/// A markups file (.mrk.json) of 3D Slicer: lines for the flexion axis of the reference and the rotation axis
/// of the moving object, the attachments by body, and the contact points where the frame is a cell of the set
/// raw.
std::string markups_in_scan(const store::MotionModel& model, const FlexionMotion& motion,
                            const ScanFrame& scan);

}  // namespace vrda::tables
