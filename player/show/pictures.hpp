/// Off-screen images of a joint at a series of poses.
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

/// The set of the motion model that the poses belong to.
struct PosedSet {
  std::string name;      ///< one of set_names(model)
  bool has_gaps = true;  ///< false for intermediate search poses, which have no gap data
};

/// Returns a renderer of the size in `options` whose shaders are compiled: it has drawn boxes with the
/// materials of bone, cartilage and meniscus. Shader compilation dominates the time to the first frame.
/// Throws InputError like make_offscreen_renderer and apply_appearance.
std::unique_ptr<Renderer> warm_renderer(const ShowOptions& options);

/// Renders a series of poses with one fixed camera per view.
class PictureMaker {
 public:
  /// `model` and `options` must outlive it; `renderer` has the size given in `options`. The cameras are
  /// fitted to all of `poses`.
  PictureMaker(const ShowOptions& options, const MotionModel& model, const PosedSet& set,
               const std::vector<JointPose>& poses, std::unique_ptr<Renderer> renderer);

  /// Renders one view (index into --views) at full size. The result is valid until the next call.
  const Image& single(std::size_t view, const JointPose& pose);
  /// Renders all views side by side. The result is valid until the next call.
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
  std::optional<Gui> gui_;  ///< with --numbers
  std::vector<Camera> single_, tiled_;
  std::vector<Shot> shots_;
};

}  // namespace vrda
