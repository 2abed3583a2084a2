/// What can be shown beside the bodies: contacts, forces, axes, gaps, ligaments.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "motion/poses.hpp"
#include "scene/layer_set.hpp"
#include "scene/palette.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// A word and the colour that stands for it.
struct Label {
  std::string name;
  VertexColour colour{};
};

/// Where a joint is, and how the screen shows it.
struct Shown {
  JointPose pose;
  JointFrames frames;  ///< of `pose`
  LayerSet layers;
};

/// The layers of one motion model in one scene. Made once; a frame updates them without allocating.
class JointLayers {
 public:
  /// Appends the layers' drawables, hidden, to `scene`, which keeps its order from then on. Copies what it
  /// needs of the model.
  JointLayers(const MotionModel& model, Scene& scene);
  ~JointLayers();
  JointLayers(JointLayers&&) noexcept;
  JointLayers& operator=(JointLayers&&) noexcept;

  /// Shows the wanted layers at a pose of `motion`, hides the others; all of them where the pose is not
  /// solved. After place(): it moves only the layers'. A mesh changes, and its revision rises, only when it
  /// must: with the pose, the cell, or not at all. Sizes stay those made.
  void update(Scene& scene, const Motion& motion, const Shown& shown);

  /// Those that the model has something for.
  const LayerSet& available() const { return available_; }
  const Legend& gap_legend() const;     ///< mm
  const Legend& strain_legend() const;  ///< percent
  /// The axes' colours: of "axes", then of "helical-axis".
  static const std::vector<Label>& axis_labels();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  LayerSet available_;
};

/// Opacity of one object's bodies: `part` of their materials' own. To look through to what lies behind.
void see_through(Scene& scene, Owner owner, float part);
/// One object's bodies out of sight; its layers stay.
void hide(Scene& scene, Owner owner);

}  // namespace vrda
