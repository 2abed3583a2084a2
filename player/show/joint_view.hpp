/// A joint on screen: the scene of a motion model with its layers, names and numbers at a pose.
#pragma once

#include <Eigen/Core>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "show/view_state.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/gui.hpp"
#include "view/labels.hpp"
#include "view/player_state.hpp"
#include "view/readings.hpp"
#include "view/scene.hpp"
#include "view/section.hpp"
#include "view/structures.hpp"

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

  const std::vector<view::Structure>& structures() const { return structures_; }
  /// What is shown of them, from the next call of show(); at first what the look says.
  view::Looks& looks() { return looks_; }
  const view::Looks& looks() const { return looks_; }
  /// Takes the structures of a state, which is of this model.
  void use(const ViewState& state);
  /// The row of a structure; empty if it has none.
  std::optional<std::size_t> structure_row(const std::string& id) const;
  /// Of a bundle at poses.
  const view::BundleReader& bundles() const { return bundles_; }

  view::Scene& scene() { return scene_; }
  const view::Scene& scene() const { return scene_; }
  const view::JointLayers& layers() const { return layers_; }

  BodyIndex fixed_object = BodyIndex::moving;  ///< on screen, from the next call of show()

 private:
  void apply_looks();

  Side side_ = Side::right;
  Eigen::Vector3d rotation_centre_mm_;
  view::Scene scene_;
  view::JointLayers layers_;
  view::SectionCaps caps_;
  std::vector<view::Structure> structures_;
  view::Looks looks_;
  view::BundleReader bundles_;
  struct DrawableRow {
    std::optional<std::size_t> structure;
    float opacity = 1.0F;  ///< of its material
  };
  std::vector<DrawableRow> rows_;   ///< [n_drawables]
  std::vector<bool> shown_bodies_;  ///< [n_drawables] by the looks
  view::LabelAnchors labels_;
  std::vector<view::ScreenLabel> screen_labels_;  ///< [n_shots * n_labels]
  view::DoubtText doubt_{};
};

}  // namespace vrda::show
