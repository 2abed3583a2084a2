/// The scene of a followed run, and its screen with views and panel.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "follow/run_state.hpp"
#include "follow/run_views.hpp"
#include "follow/run_watch.hpp"
#include "gui/overlay_text.hpp"
#include "motion/poses.hpp"
#include "render/renderer.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"
#include "view/gaze.hpp"

namespace vrda {

struct RunSceneOptions {
  LayerSet layers;  ///< the helical axis is available only for a result
  Backdrop backdrop = Backdrop::studio;
  std::function<void(Scene&)> dress;  ///< applies the appearance to a new scene; may be empty
};

class RunScene {
 public:
  /// From a start file or a result; shows both objects at the first flexion with zero translation and
  /// rotation.
  RunScene(const MotionModel& model, const RunSceneOptions& options);

  /// Shows the pose of a step; the attitude rotates the reference, as in the search.
  void show(const SeenStep& step);
  /// Shows a pose of `motion`, a set of the result that the scene was made from.
  void show(const JointPose& pose, const Motion& motion);

  const Scene& scene() const { return scene_; }
  const JointPose& pose() const { return pose_; }
  /// Increases when a renderer must reload the scene.
  std::uint64_t n_layouts() const { return n_layouts_; }
  /// Loads the scene into a renderer at the full contact capacity.
  void load(Renderer& renderer);

  /// The points to be framed, world: near the joint at first, middle and last flexion, at the present
  /// translation.
  std::vector<Eigen::Vector3d> framed_points() const;

 private:
  void place_bodies(const JointPose& pose, const Motion& motion, const LayerSet& layers);
  LayerSet layers_of_step() const;
  void place_markers(const SeenStep& step);
  void hide_markers();
  void make_room(std::size_t n_contacts);

  RunSceneOptions options_;
  Scene scene_;
  Motion raw_;
  SolverFrame frame_;                    // at the first flexion
  std::vector<Eigen::Vector3d> deltas_;  // [n_flexion]
  double scale_ = 1.0;
  std::optional<JointLayers> layers_;    // all layers except contacts and normals of steps
  std::size_t points_ = 0, arrows_ = 0;  // drawables
  std::size_t n_markers_ = 0;            // contact capacity
  std::vector<std::uint32_t> point_triangles_, arrow_triangles_;
  JointPose pose_;
  std::uint64_t n_layouts_ = 1;
};

struct RunScreenOptions {
  int width = 1280, height = 960;
  RunSceneOptions scene;
  std::vector<RunView> views;  ///< at least one
  double zoom = 1.0;
};

/// Views and panel of a run, as scene, shots and overlay for a renderer.
class RunScreen {
 public:
  RunScreen(const MotionModel& model, const RunScreenOptions& options);

  /// Resets for a restarted run, possibly of another joint.
  void begin(const MotionModel& model);
  /// Shows the step of the state, and its panel with additional lines. The first step sets the cameras.
  void show(const RunState& state, const std::vector<std::string>& lines);
  /// Switches to the result of the finished run; keeps the cameras.
  void finish(const MotionModel& result);
  /// Shows a pose of `motion`, a set of the result.
  void show(const RunState& state, const std::vector<std::string>& lines, const JointPose& pose,
            const Motion& motion);
  /// Sets the size in pixels. Returns true if it changed; show() must follow.
  bool resize(int width, int height);

  // Pointer interaction; each view has its own camera.
  std::optional<std::size_t> view_at(const Eigen::Vector2d& pointer_px) const;
  Gaze gaze(std::size_t view) const;
  void look(std::size_t view, const Gaze& gaze);
  /// Refits the cameras of all views.
  void reset_views();

  /// Loads new meshes and fonts into the renderer; must precede its draw() or present().
  void load(Renderer& renderer);
  const Scene& scene() const { return scene_->scene(); }
  const std::vector<Shot>& shots() const { return shots_; }
  const Overlay& overlay() const { return overlay_; }

 private:
  void make_text();
  void fit_cameras();
  void set_depths();
  void draw_overlay(const RunState& state, const std::vector<std::string>& lines);

  RunScreenOptions options_;
  std::optional<RunScene> scene_;
  std::optional<OverlayText> text_;
  Viewport panel_area_;
  std::vector<Shot> shots_;
  Overlay overlay_;
  std::vector<Eigen::Vector3d> pivots_world_mm_;  // one per view
  bool has_step_ = false;                         // the cameras were fitted to a step
  std::uint64_t n_loaded_layouts_ = 0;
  bool is_font_loaded_ = false;
};

}  // namespace vrda
