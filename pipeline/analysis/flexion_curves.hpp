/// Quantities over flexion that are computed from a motion model's meshes and poses. `info` prints their
/// ranges, the CSV export has a column of each, the report a plot of each group. To add one: a function in a
/// file of its own, declared below, and its row in flexion_curves.cpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/frames.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// One quantity at each pose of a motion.
struct Curve {
  std::string name;            ///< key in JSON and column of the CSV, with the unit: "shift_medial_mm"
  std::string label;           ///< "medial"
  std::vector<double> values;  ///< [n_poses] in the unit of the group; NaN without a pose
};

/// Curves that are drawn in one plot.
struct CurveGroup {
  std::string title;          ///< "Shift"
  std::string caption;        ///< one sentence: what is measured, and how
  std::string unit;           ///< as written: "mm"
  std::vector<Curve> curves;  ///< at least one
};

/// All groups of `model` at the poses of a motion.
/// model: with its meshes; of any joint.
/// poses: [n_poses] solved.
/// n_threads: at least 1; the same bits for any number.
/// Cost: some ms a pose.
std::vector<CurveGroup> flexion_curves(const store::MotionModel& model,
                                       const std::vector<store::JointPose>& poses, int n_threads);

/// All groups along the raw spine: a value for each flexion of the grid, or for each frame of a sequence.
/// Arguments as above.
std::vector<CurveGroup> spine_curves(const store::MotionModel& model, int n_threads);

/// Whether a column of this name is a curve of this file, whatever the model.
bool is_flexion_curve(std::string_view column);

// The analyses.

/// Cartilage that is compressed by 1 mm in all where scans show the surfaces in contact.
inline constexpr double contact_area_distance_mm = 1.0;

/// Area of the moving object's contact surface within contact_area_distance_mm of a surface of the reference
/// that faces it, of each compartment, or of the whole surface where the joint has no compartments. The
/// distance is linear over a triangle between those of its vertices to the nearest facing triangle; an error
/// of a few percent of the triangles along the edge of the area remains. Arguments as flexion_curves().
std::vector<CurveGroup> contact_area(const store::MotionModel& model,
                                     const std::vector<store::JointPose>& poses, int n_threads);

/// Rotations and displacements of each body that follows the joint (model/coordinates.hpp). Arguments as
/// flexion_curves(); NaN where it has no pose.
std::vector<CurveGroup> follower_curves(const store::MotionModel& model,
                                        const std::vector<store::JointPose>& poses, int n_threads);

}  // namespace vrda::analysis
