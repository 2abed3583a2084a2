/// Poses of a joint at any attitude, from one set of surfaces of a motion model.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"
#include "motion/raw_surfaces.hpp"
#include "motion/smoothed_surfaces.hpp"
#include "store/motion_model.hpp"

namespace vrda {

enum class PoseStatus {
  solved,
  unsolved_cell,  ///< raw set only: a cell around the attitude has no answer
};

const char* name_of(PoseStatus status);

/// Where both objects stand. World W: origin at the rotation centre, canonical axes of the joint's own
/// side; both poses take stored (canonical, not recentred) vertices. Identity where not solved.
struct JointPose {
  Pose X_world_reference = Pose::Identity();
  Pose X_world_moving = Pose::Identity();
  Pose X_reference_moving = Pose::Identity();
  double theta_rad = 0.0;  ///< about Delta, right-knee sign
  Attitude attitude;       ///< where it was evaluated: the attitude asked for, clamped
  bool is_flexion_clamped = false;
  bool is_varus_clamped = false;  ///< also where varus was free and another one was asked for
  PoseStatus status = PoseStatus::unsolved_cell;
};

/// The sets `Motion` can be made of: smoothed ones by falling degree ("degree_6", ...), then "raw".
std::vector<std::string> set_names(const MotionModel& model);

/// One set of a motion model, ready for evaluation. Copies what it needs of the model.
class Motion {
 public:
  /// `set` must be one of set_names(model); the grids must have the size of the axes.
  Motion(const MotionModel& model, const std::string& set);

  /// The poses at `wanted`, or at the nearest attitude of the measured range. Under a microsecond,
  /// allocates nothing.
  JointPose at(const Attitude& wanted) const;

  /// The poses where `numbers` stand for the moving object at `attitude`, whatever the set says of it.
  JointPose placed(const Attitude& attitude, const PoseNumbers& numbers) const;

  /// Varus at which the compartments are most nearly in balance: linear in flexion between the solved
  /// spine cells, constant beyond the first and last; without any, 0 or the nearest varus measured. Where
  /// varus was free, the one found.
  double balanced_varus_rad(double flexion_rad) const;
  bool has_spine() const { return !spine_.empty(); }
  /// Each flexion has the varus that was found, not one that was given.
  bool is_varus_free() const { return !free_varus_.empty(); }

  double first_flexion_rad() const { return raw_.flexion_rad.front(); }
  double last_flexion_rad() const { return raw_.flexion_rad.back(); }
  double first_varus_rad() const { return first_varus_rad_; }
  double last_varus_rad() const { return last_varus_rad_; }

 private:
  RawSample numbers_at(const Attitude& attitude) const;
  double varus_at(const Attitude& wanted) const;
  Eigen::Matrix3d R_world_solver(double flexion_rad) const;

  SolverFrame frame_;                    ///< of the first flexion
  Eigen::Matrix3d R_world_solver_;       ///< of frame_: orthogonal; a reflection for a left joint
  std::vector<Eigen::Vector3d> deltas_;  ///< one a flexion; empty where all are that of frame_
  std::vector<Attitude> free_varus_;     ///< solved, by ascending flexion; empty where varus was given
  double first_varus_rad_ = 0.0, last_varus_rad_ = 0.0;
  RawSurfaces raw_;                           ///< its axes are the measured range
  std::optional<SmoothedSurfaces> smoothed_;  ///< unless the set is "raw"
  std::vector<Attitude> spine_;               ///< solved spine cells by ascending flexion
};

}  // namespace vrda
