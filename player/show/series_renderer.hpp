/// Off-screen images of a joint at a series of poses: one fixed camera per view, so that frames are
/// comparable. In: motion model and poses (mm, rad). Out: RGB images of the size in the options.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "show/joint_view.hpp"
#include "show/show.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/gui.hpp"
#include "view/keys.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"

namespace vrda::show {

/// The set of the motion model that the poses belong to.
struct PosedSet {
  std::string name;      ///< one of set_names(model)
  bool has_gaps = true;  ///< false for intermediate search poses, which have no gap data
  std::span<const store::JointPose> played = {};  ///< of a video
};

/// Returns a renderer of the size in `options` whose shaders are compiled: it has drawn triangles with the
/// materials of bone, cartilage and meniscus. Shader compilation dominates the time to the first frame.
/// Throws InputError like make_offscreen_renderer and apply_appearance.
std::unique_ptr<view::Renderer> warm_renderer(const ShowOptions& options);

/// Renders a series of poses with one fixed camera per view.
class SeriesRenderer {
 public:
  /// `model` and `options` must outlive it; `renderer` has the size given in `options`. The cameras are
  /// fitted to all of `poses`, which are solved.
  SeriesRenderer(const ShowOptions& options, const store::MotionModel& model, const PosedSet& set,
                 const std::vector<store::JointPose>& poses, std::unique_ptr<view::Renderer> renderer);

  const ResolvedPictures& look() const { return look_; }

  /// Of a pose that is not solved only the fixed object is drawn, with the reason.
  /// Renders one view (index into look().views) at full size. The result is valid until the next call.
  const view::Image& draw_single(std::size_t view, const store::JointPose& pose);
  /// Renders all views side by side. The result is valid until the next call.
  const view::Image& draw_tiled(const store::JointPose& pose);

 private:
  void make_interface(const store::MotionModel& model, const PosedSet& set,
                      const std::vector<store::JointPose>& poses);
  std::vector<view::Camera> cameras_for(const std::vector<store::JointPose>& poses, double aspect);
  const view::Overlay* overlay_for(const store::JointPose& pose);
  const view::Image& drawn(const store::JointPose& pose);

  const ShowOptions& options_;
  ResolvedPictures look_;
  PlayedSet set_;
  bool has_gaps_ = true;
  view::DoubtReader doubts_;
  JointView joint_;
  view::LayerSet wanted_;
  std::unique_ptr<view::Renderer> renderer_;
  std::string remark_;            ///< why the solved poses are the default motion, or empty
  std::optional<view::Gui> gui_;  ///< with --numbers, labels or doubtful poses
  view::Viewport area_;           ///< of the picture, below the warnings
  std::vector<view::Camera> single_, tiled_;
  std::vector<view::Shot> shots_;
};

}  // namespace vrda::show
