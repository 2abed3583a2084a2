/// The exported motion: poses of one set of a motion model along flexion, or the frames of a sequence.
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "core/fields.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::tables {

/// Source of the varus of each flexion.
enum class VarusRule {
  given,  ///< one constant varus
  spine,  ///< Motion::balanced_varus_rad: varus of the sweep's spine, or the one found where it was free
  zero,   ///< varus of the zero-varus table, linear between its flexions
};
inline constexpr Named<VarusRule> varus_rule_names[] = {
    {VarusRule::given, "given"}, {VarusRule::spine, "spine"}, {VarusRule::zero, "zero"}};
constexpr const auto& names_of(VarusRule)
{
  return varus_rule_names;
}

struct FlexionPlan {
  std::string set;                  ///< one of all_set_names(model); empty: store::default_motion
  std::vector<double> flexion_deg;  ///< ascending; empty: the model's
  VarusRule varus = VarusRule::spine;
  double varus_deg = 0.0;  ///< of VarusRule::given
};

struct FlexionFrame {
  double flexion_deg = 0.0;      ///< as requested; of a sequence that of the frame
  store::JointPose pose;         ///< solved; with the key in a sequence
  ClinicalCoordinates clinical;  ///< of pose.X_reference_moving; continuous over the frames
};

struct OmittedFlexion {
  double flexion_deg = 0.0;
  double key = nan;  ///< of a sequence
  std::string reason;
};

struct FlexionMotion {
  std::string title;  ///< of the model
  std::string set;
  std::string reason;     ///< why the default motion is not the smoothed one; empty if the plan names a set
  std::string statement;  ///< of a model with a prior, on its default motion; likewise
  Side side = Side::right;
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical
  std::string key_name;                                          ///< of a sequence; else empty
  std::vector<FlexionFrame> frames;                              ///< in ascending flexion or key
  std::vector<OmittedFlexion> omitted;                           ///< flexions without a pose
  int n_locked = 0;                                              ///< frames at gimbal lock or beyond
};

/// `zero` if the model has a zero-varus table, otherwise `spine`; of the raw poses `spine`, as they are shown
/// everywhere else. `set` as in FlexionPlan.
VarusRule default_varus(const store::MotionModel& model, const std::string& set);

/// The poses of `plan`. Flexions without a pose are omitted and listed: poses are not clamped to the measured
/// range or interpolated across a hole. Throws InputError naming `file` if the model does not have the set,
/// the varus rule is not available (given although varus was free, zero without a table), or no pose remains.
/// A sequence of frames is exported whole: throws InputError if the plan chooses flexions or varus.
FlexionMotion flexion_motion(const store::MotionModel& model, const std::string& file,
                             const FlexionPlan& plan);

/// Whether a body that follows the joint has a pose in every frame; otherwise it is left out.
bool is_posed(const FlexionMotion& motion, const store::FollowerRows& follower);

/// "raw", with the reason if there is one: "raw: two_sided (degree 4) does not meet ...".
std::string set_text(const FlexionMotion& motion);

/// Flexion in degrees, or the key in a sequence.
double abscissa(const FlexionMotion& motion, const FlexionFrame& frame);

/// Time of a frame in s, 0 at the first frame, for flexion (degrees) or key at `rate` a second; of a sequence
/// over time_s its own time, 0 at the first frame.
double time_s(const FlexionMotion& motion, const FlexionFrame& frame, double rate);

}  // namespace vrda::tables
