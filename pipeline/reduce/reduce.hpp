/// Reduces a motion over flexion and varus to one over flexion alone: both condyles bearing (DESIGN.md 5.5).
/// schemas/clinical.md writes every rule and formula out.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/mesh.hpp"
#include "motion/poses.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// The zero varus of one flexion. Columns are solved ones; both are the same where it falls on a column.
struct VarusChoice {
  ZeroVarusSource source = ZeroVarusSource::none;
  double varus_deg = std::numeric_limits<double>::quiet_NaN();
  double first_deg = std::numeric_limits<double>::quiet_NaN();  ///< of both_touch only, like last_deg
  double last_deg = std::numeric_limits<double>::quiet_NaN();
  Eigen::Index before = 0, after = 0;  ///< columns around it
  double share_after = 0.0;            ///< weight of `after` in a linear interpolation
};

/// [n_flexion]. Where varus was free: the one found. Else, where some solved columns touch with both
/// compartments: the mean of the first and last of them; columns between them that do not touch with both
/// part them into runs, of which the one nearest to the spine counts. Else the root, nearest to the spine, of
/// gap_medial - gap_lateral, linear between neighbouring solved columns. Else none.
/// `raw` is the motion of the model's raw surfaces.
/// Source: thesis 5.4, which knows one run only.
std::vector<VarusChoice> varus_choices(const MotionModel& model, const Motion& raw);

/// A compartment at one pose. The two points are one place of contact.
struct Bearing {
  Pose X_reference_moving = Pose::Identity();
  Eigen::Vector3d p_reference_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_moving_mm = Eigen::Vector3d::Zero();
};

/// Travels are signed lengths in the sagittal plane (X anterior, Y proximal) of the moving body, anterior
/// positive.
struct Rolling {
  double reference_mm = 0.0;  ///< travel of the contact over the reference body
  double moving_mm = 0.0;     ///< travel of the contact over the moving body
  double rolling_mm = 0.0;    ///< what both share: the shorter where they go the same way, else 0
  double sliding_mm = 0.0;    ///< moving_mm - reference_mm: the reference's surface slides forward so far
};

/// From one bearing to the next. The reference's travel is brought into the moving body's axes midway between
/// both poses. Straight lines stand for arcs: of a circle turned by a they are short by a^2 / 24.
/// Source: rolling of two bodies upon each other; schemas/clinical.md writes it out.
Rolling rolling_between(const Bearing& start, const Bearing& end);

/// Whether the question has a meaning: the joint has compartments, or varus was free.
bool is_reducible(const MotionModel& model);

/// The flexion-only motion: varus from the raw cells, poses there from the set named, one of
/// set_names(model). Poses of "raw" are linear between the two columns around, or the cell's own; contact
/// points are those of the raw cells whatever the set. The model must be reducible; flexions without an
/// answer have source none, possibly all.
ZeroVarus reduce(const MotionModel& model, const std::string& set);

/// Flexions with a pose.
int n_reduced(const ZeroVarus& zero_varus);

}  // namespace vrda
