/// A joint on screen: the scene of a motion model with its layers, names and numbers at a pose.
#pragma once

#include <Eigen/Core>

#include <span>
#include <string>
#include <vector>

#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/gap_reading.hpp"
#include "view/gui.hpp"
#include "view/overlay_text.hpp"
#include "view/player_state.hpp"
#include "view/scene.hpp"

namespace vrda::show {

/// One set of a model: its poses and gap readings. The model must outlive it.
struct PlayedSet {
  PlayedSet(const store::MotionModel& model, const std::string& name) : motion(model, name), gaps(model, name)
  {
  }
  store::Motion motion;
  view::GapReader gaps;
};

class JointView {
 public:
  /// Copies what it needs of the model. Throws InputError for an invalid look.
  JointView(const store::MotionModel& model, const view::AppearanceOptions& look, view::Backdrop backdrop);

  /// Shows a pose of `motion`, a set of the model, with `layers`; of one that is not solved only the fixed
  /// body, or the reference. Allocates nothing.
  void show(const store::Motion& motion, const store::JointPose& pose, const view::LayerSet& layers);
  /// The numbers of the pose, with what is wrong with it; the text is valid until the next call.
  view::Readout readout(const PlayedSet& set, const store::JointPose& pose, const view::PoseDoubt& doubt);
  /// The names at the shown pose, for each of the shots; valid until the next call. Allocates nothing once
  /// called with as many shots.
  std::span<const view::ScreenLabel> labels(std::span<const view::Shot> shots);
  /// Places the bodies at a solved pose; returns the points to be framed, world.
  std::vector<Eigen::Vector3d> framed_points(const store::JointPose& pose, view::Framing framing);

  view::Scene& scene() { return scene_; }
  const view::Scene& scene() const { return scene_; }
  const view::JointLayers& layers() const { return layers_; }

  BodyIndex fixed_object = BodyIndex::moving;  ///< on screen, from the next call of show()

 private:
  Side side_ = Side::right;
  Eigen::Vector3d rotation_centre_mm_;
  view::Scene scene_;
  view::JointLayers layers_;
  std::vector<bool> shown_bodies_;  ///< [n_drawables] by the look
  std::vector<store::JointLabel> labels_;
  std::vector<view::ScreenLabel> screen_labels_;  ///< [n_shots * n_labels]
  view::JointFrames frames_;                      ///< of the shown pose
  view::DoubtText doubt_{};
};

}  // namespace vrda::show
