/// Poses of a joint at any attitude, from one set of surfaces of a motion model.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/frames.hpp"
#include "motion/surfaces.hpp"
#include "store/motion_model.hpp"

namespace vrda {

enum class PoseStatus {
  solved,
  unsolved_cell,  ///< a cell around the attitude has no answer; of the set "degree_N" never
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
  bool is_varus_clamped = false;  ///< also where the set has a varus of its own and another was asked for
  PoseStatus status = PoseStatus::unsolved_cell;
};

/// A small motion of the moving object relative to the reference: its point now at p_mm, in the frame of the
/// stored reference vertices, moves by turn.cross(p_mm) + shift_mm. The instantaneous helical axis runs along
/// turn through turn.cross(shift_mm) / turn.squaredNorm().
struct Twist {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
};

/// Derivatives by one angle of the attitude, a radian.
struct PoseRate {
  PoseNumbers numbers{};  ///< of x, y, z (mm, world W) and theta (rad, right-knee sign)
  double varus = 0.0;     ///< of the varus it stands at, rad
  Twist twist;            ///< of the moving object relative to the reference
};

/// A pose and how it goes on from there. At an end of the measured range the derivatives are those from
/// within.
struct JointRate {
  JointPose pose;
  PoseRate by_flexion, by_varus;
  /// Whether the motion goes on along that angle. If not, its rate is all 0: without a pose, where the angle
  /// was clamped or has one value, and of varus where the set has its own.
  bool is_flexion_free = false, is_varus_free = false;
};

/// The sets `Motion` can be made of, what to show first: smoothed ones by falling degree, each after the one
/// recontacted from it, in which nothing overlaps or gapes ("degree_6_recontacted", "degree_6", ...); then
/// "raw"; last "zero_varus", which knows flexion only.
std::vector<std::string> set_names(const MotionModel& model);

/// One set of a motion model, ready for evaluation. Copies what it needs of the model.
class Motion {
 public:
  /// `set` must be one of set_names(model); the grids must have the size of the axes.
  Motion(const MotionModel& model, const std::string& set);
  /// The smoothed surfaces of `set`, which need not be one of the model's; never recontacted.
  Motion(const MotionModel& model, const SmoothedSet& set);

  /// The poses at `wanted`, or at the nearest attitude of the measured range. Under a microsecond,
  /// allocates nothing.
  JointPose at(const Attitude& wanted) const;

  /// at(wanted) with its derivatives by flexion and varus, of every set. Under a microsecond, allocates
  /// nothing.
  JointRate rate_at(const Attitude& wanted) const;

  /// The poses where `numbers` stand for the moving object at `attitude`, whatever the set says of it.
  JointPose placed(const Attitude& attitude, const PoseNumbers& numbers) const;

  /// Varus at which the compartments are most nearly in balance: linear in flexion between the solved
  /// spine cells, constant beyond the first and last; without any, 0 or the nearest varus measured. Where
  /// the set has a varus of its own, that one.
  double balanced_varus_rad(double flexion_rad) const;
  bool has_spine() const { return !spine_.empty(); }
  /// Each flexion has the varus that was found, not one that was given: varus was free, or the set is
  /// "zero_varus".
  bool is_varus_free() const { return !free_varus_.empty(); }

  /// Unit, world W: linear between the rows of the push, held beyond the ends, then normalised.
  Eigen::Vector3d delta(double flexion_rad) const;

  double first_flexion_rad() const { return raw_.flexion_rad.front(); }
  double last_flexion_rad() const { return raw_.flexion_rad.back(); }
  double first_varus_rad() const { return first_varus_rad_; }
  double last_varus_rad() const { return last_varus_rad_; }

 private:
  struct Found {
    Attitude attitude;
    PoseNumbers numbers{};
    bool is_solved = false;
  };
  explicit Motion(const MotionModel& model);
  void set_varus_range();
  void use_smoothed(const MotionModel& model, const SmoothedSet& set);
  void use_travel(const GridD& travel_mm);
  void use_zero_varus(const ZeroVarus& table);
  /// With the numbers' derivatives, and that of the varus where the set has its own.
  struct FoundRate {
    Found found;
    PoseNumbers by_flexion{}, by_varus{};
    double varus_by_flexion = 0.0;
  };
  Attitude clamped(const Attitude& wanted) const;
  Found found_at(const Attitude& attitude) const;
  Attitude own_varus(const Attitude& wanted) const;
  JointPose posed(const Found& found, const Attitude& wanted) const;
  FoundRate found_rate_at(const Attitude& attitude) const;
  FoundRate smoothed_rate_at(const Attitude& attitude) const;
  FoundRate raw_rate_at(const Attitude& attitude) const;
  FoundRate zero_varus_rate_at(const Attitude& attitude) const;
  Eigen::Vector3d delta_rate(double flexion_rad) const;
  Eigen::Vector3d solver_turn(double flexion_rad, const Eigen::Matrix3d& R) const;
  void set_twists(JointRate& rate) const;
  Found smoothed_at(const Attitude& attitude) const;
  Found zero_varus_at(const Attitude& attitude) const;
  Eigen::Matrix3d R_world_solver(double flexion_rad) const;

  SolverFrame frame_;                    ///< of the first flexion
  Eigen::Matrix3d R_world_solver_;       ///< of frame_: orthogonal; a reflection for a left joint
  std::vector<Eigen::Vector3d> deltas_;  ///< one a flexion; empty where all are that of frame_
  std::vector<Attitude> free_varus_;     ///< solved, by ascending flexion; empty where varus is asked for
  double first_varus_rad_ = 0.0, last_varus_rad_ = 0.0;
  RawSurfaces raw_;                           ///< its axes are the measured range
  std::optional<SmoothedSurfaces> smoothed_;  ///< of "degree_N" and "degree_N_recontacted"
  std::optional<HermiteGrid<1>> travel_;      ///< along Delta, mm; of "degree_N_recontacted"
  std::optional<HermiteGrid<5>> zero_varus_;  ///< over flexion; of "zero_varus"
  std::vector<Attitude> spine_;               ///< solved spine cells by ascending flexion
};

}  // namespace vrda
