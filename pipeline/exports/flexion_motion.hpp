/// The motion that leaves the program: poses of one set of a motion model along flexion.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/clinical.hpp"
#include "motion/poses.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Where the varus of each flexion comes from.
enum class VarusRule {
  given,  ///< one varus throughout
  spine,  ///< Motion::balanced_varus_rad: that of the sweep's spine, or the one found where it was free
  zero,   ///< that of the zero-varus table, linear between its flexions
};

const char* name_of(VarusRule rule);

struct FlexionPlan {
  std::string set;                  ///< one of set_names(model); empty: the first of them
  std::vector<double> flexion_deg;  ///< ascending; empty: those of the model
  VarusRule varus = VarusRule::spine;
  double varus_deg = 0.0;  ///< of VarusRule::given
};

struct FlexionFrame {
  double flexion_deg = 0.0;  ///< as asked for
  JointPose pose;            ///< solved
  Clinical clinical;         ///< of pose.X_reference_moving
};

struct LeftOut {
  double flexion_deg = 0.0;
  std::string why;
};

struct FlexionMotion {
  std::string title;  ///< of the model
  std::string set;
  Side side = Side::right;
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical
  std::vector<FlexionFrame> frames;                              ///< by ascending flexion
  std::vector<LeftOut> left_out;                                 ///< flexions without a pose
};

/// zero where the model has a zero-varus table, else spine.
VarusRule default_varus(const MotionModel& model);

/// The poses of `plan`, those without an answer left out: nothing is clamped to the measured range or bridged
/// across a hole. Throws InputError naming `file` where the set is none of the model's, where the varus
/// cannot be had (a given one although it was free, zero without a table), or where no pose is left.
FlexionMotion flexion_motion(const MotionModel& model, const std::string& file, const FlexionPlan& plan);

/// When a frame is shown, from 0 at the first on, flexing by `degrees_per_second`.
double time_s(const FlexionMotion& motion, const FlexionFrame& frame, double degrees_per_second);

}  // namespace vrda
