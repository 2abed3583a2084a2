/// The scene of a run in progress and its screen with views and panel. In: the meshes of a start file or
/// result (mm, canonical), poses of finished steps. Out: drawn frames.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "show/joint_view.hpp"
#include "show/loop.hpp"
#include "show/run_watch.hpp"
#include "show/show.hpp"
#include "store/motion.hpp"
#include "view/layers.hpp"
#include "view/orbit_camera.hpp"
#include "view/overlay_text.hpp"
#include "view/player_state.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"

namespace vrda::show {

/// The appearance of a run: its views and layers; the helical axis is available only for a result.
struct RunScreenOptions {
  ResolvedPictures pictures;
  view::LayerSet layers;
  view::Backdrop backdrop = view::Backdrop::studio;
};

class RunScene {
 public:
  /// From a start file or a result; shows both objects at the first flexion with zero translation and
  /// rotation.
  RunScene(const store::MotionModel& model, const RunScreenOptions& options);

  /// Shows the pose of a step; the attitude rotates the reference, as in the search.
  void show(const RunStep& step);
  /// Shows a pose of `motion`, a set of the result that the scene was made from; of one that is not solved
  /// only the reference.
  void show(const store::JointPose& pose, const store::Motion& motion) { place(pose, motion, wanted_); }

  const view::Scene& scene() const { return joint_.scene(); }
  /// Increases when a renderer must reload the scene.
  std::uint64_t n_layouts() const { return n_layouts_; }

  /// The points to be framed, world: near the joint at first, middle and last flexion, at the present
  /// translation.
  std::vector<Eigen::Vector3d> framed_points() const;

 private:
  void place(const store::JointPose& pose, const store::Motion& motion, const view::LayerSet& layers);
  void place_markers(const RunStep& step, const SolverFrame& frame);
  void reserve_markers(std::size_t n_contacts);

  view::LayerSet wanted_, of_steps_;  // those of steps lack contacts and normals, which are markers
  JointView joint_;
  store::Motion raw_;
  SolverFrame frame_;                    // at the first flexion
  std::vector<Eigen::Vector3d> deltas_;  // [n_flexion]
  double scale_ = 1.0;
  view::ContactMarkers points_, arrows_;  // of steps
  store::JointPose pose_;
  std::uint64_t n_layouts_ = 1;
};

/// Views and panel of a run, as scene, shots and overlay for a renderer.
class RunScreen {
 public:
  RunScreen(const store::MotionModel& model, const RunScreenOptions& options);

  /// Resets for a restarted run, possibly of another joint.
  void restart(const store::MotionModel& model);
  /// Shows the step of the state, and its panel with additional lines. The first step sets the cameras.
  void show(const RunState& state, const std::vector<std::string>& lines);
  /// Switches to the result of the finished run; keeps the cameras.
  void finish(const store::MotionModel& result);
  /// Shows a pose of `motion`, a set of the result.
  void show(const RunState& state, const std::vector<std::string>& lines, const store::JointPose& pose,
            const store::Motion& motion);
  /// Sets the size in pixels. Returns true if it changed; show() must follow.
  bool resize(int width, int height);

  // Pointer interaction; each view has its own camera.
  std::optional<std::size_t> view_at(const Eigen::Vector2d& pointer_px) const;
  view::OrbitCamera orbit_camera(std::size_t view) const
  {
    return {shots_[view].camera, pivots_world_mm_[view]};
  }
  void set_orbit_camera(std::size_t view, const view::OrbitCamera& gaze);
  /// Fits the cameras of all views to the joint.
  void fit_cameras();

  /// Loads new meshes and fonts into the renderer; must precede its draw() or present().
  void load(view::Renderer& renderer);
  const view::Scene& scene() const { return scene_->scene(); }
  const std::vector<view::Shot>& shots() const { return shots_; }
  const view::Overlay& overlay() const { return overlay_; }

 private:
  void set_depths();
  void draw(const RunState& state, const std::vector<std::string>& lines, bool has_pose);

  RunScreenOptions options_;
  int width_ = 0, height_ = 0;
  std::optional<RunScene> scene_;
  std::optional<view::OverlayText> text_;
  view::Viewport panel_area_;
  std::vector<view::Shot> shots_;
  view::Overlay overlay_;
  std::vector<Eigen::Vector3d> pivots_world_mm_;  // one per view
  bool has_step_ = false;                         // the cameras were fitted to a step
  std::uint64_t n_loaded_layouts_ = 0;
  bool is_font_loaded_ = false;
};

// The mode `follow`: shows a run while it computes.

/// The options of `follow`.
struct FollowOptions : PictureOptions {
  FollowOptions() { appearance.layers = "contacts,normals"; }

  double every_s = 0.0;          ///< write an image at this interval if there are new steps; 0: off
  int every_n_steps = 0;         ///< write an image every N steps; 0: off
  bool is_once = false;          ///< report the present state and exit
  bool is_text = false;          ///< print progress only, without images
  std::string steps = "stable";  ///< one of step_choice_names()
  std::string orient, shift;     ///< X,Y,Z;X,Y,Z;... one triple per view, degrees and mm
  bool is_opaque = false;        ///< false: the reference is transparent if contacts are shown
};

/// Why following ended.
enum class FollowEnd {
  finished,  ///< the run finished, or `is_once` was set
  stopped    ///< Ctrl-C or the window was closed before the run finished
};

/// Runs the mode. `streams.data` gets one path per image, or the progress if no images are written. Throws
/// InputError for invalid input.
FollowEnd follow(const FollowOptions& options, const Streams& streams);

/// Converts the options to those of the screen for a run with this model. Throws InputError like follow().
RunScreenOptions screen_options(const FollowOptions& options, const store::MotionModel& model);

}  // namespace vrda::show
