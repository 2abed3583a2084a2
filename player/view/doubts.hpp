/// What a motion model says against its poses: the plausibility of the cells around a pose, cells without a
/// pose, and the warnings about its job.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "model/plausibility.hpp"
#include "store/poses.hpp"
#include "store/motion_model.hpp"

namespace vrda::view {

struct PoseDoubt {
  Plausibility plausibility = Plausibility::nothing_found;  ///< the first of doubtful_plausibilities around
  bool is_beside_hole = false;  ///< a cell around has no pose, or the pose itself is missing
};

/// A part of the timeline whose poses are doubtful or missing, in positions of the timeline.
struct MarkedSpan {
  double first = 0.0, last = 0.0;
  bool has_pose = true;
};

class DoubtReader {
 public:
  /// `model` must outlive it.
  explicit DoubtReader(const store::MotionModel& model) : model_(model) {}
  /// Of the cells around the pose, of any set of the model. Allocates nothing.
  PoseDoubt at(const store::JointPose& pose) const;
  /// The spans between neighbouring flexions, or frames, of the model, at `varus_rad` or the balanced varus.
  std::vector<MarkedSpan> marks(const store::Motion& motion, std::optional<double> varus_rad) const;

 private:
  const store::MotionModel& model_;
};

/// Zero-terminated; empty: nothing to say.
using DoubtText = std::array<char, 320>;
/// What is wrong with a pose, as one line; `drawn` is the name of the body that is drawn without a pose.
/// Allocates nothing.
DoubtText doubt_text(const store::JointPose& pose, const PoseDoubt& doubt, const char* drawn);

/// The counts of doubtful and missing poses with their reasons, then the warnings about the job.
std::vector<std::string> model_warnings(const store::MotionModel& model);
/// Why the solved poses of `set` are shown; empty unless it is the default motion in place of the smoothed
/// one.
std::string default_motion_remark(const store::MotionModel& model, const std::string& set);
/// Whether a cell is doubtful or has no pose.
bool has_doubtful_poses(const store::MotionModel& model);

}  // namespace vrda::view
