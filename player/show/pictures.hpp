/// Pictures of a joint at the poses of a series, without a window.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gui/gui.hpp"
#include "motion/poses.hpp"
#include "render/renderer.hpp"
#include "scene/joint_layers.hpp"
#include "show/show.hpp"
#include "store/motion_model.hpp"
#include "view/arguments.hpp"
#include "view/gap_reading.hpp"

namespace vrda {

/// Which motion the poses are of.
struct PosedSet {
  std::string name;      ///< one of set_names(model)
  bool has_gaps = true;  ///< false: poses of a search on its way, of which no gap is known
};

/// A renderer of `options`' size that has drawn its first picture, of boxes as bones, cartilage and menisci
/// look: what the first picture of a joint waits for most, done before there is a joint. Throws InputError as
/// make_offscreen_renderer and dress do.
std::unique_ptr<Renderer> warm_renderer(const ShowOptions& options);

/// One camera a view for the whole series: the joint moves, the picture does not.
class PictureMaker {
 public:
  /// `model` must outlive it; `renderer` is of the options' size; of `options` counts how to draw. Cameras
  /// have room for every one of `poses`.
  PictureMaker(const ShowOptions& options, const MotionModel& model, const PosedSet& set,
               const std::vector<JointPose>& poses, std::unique_ptr<Renderer> renderer);

  /// One view (a row of --views), as large as the picture. Valid until the next.
  const Image& single(std::size_t view, const JointPose& pose);
  /// All views side by side.
  const Image& tiled(const JointPose& pose);

 private:
  std::vector<Camera> cameras_for(const std::vector<JointPose>& poses, double aspect);
  const Overlay* overlay_for(const JointPose& pose);
  const Image& drawn(const JointPose& pose);

  const ShowOptions& options_;
  std::vector<std::string> views_;
  PictureSize size_;
  Side side_ = Side::right;
  Motion motion_;
  GapReader gaps_;
  bool has_gaps_ = true;
  Scene scene_;
  JointLayers layers_;
  LayerSet wanted_;
  std::unique_ptr<Renderer> renderer_;
  std::optional<Gui> gui_;  ///< with --overlay
  std::vector<Camera> single_, tiled_;
  std::vector<Shot> shots_;
};

}  // namespace vrda
