/// The joint as a run moves it, and views and panel of the run as a renderer draws them.
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
  LayerSet layers;  ///< the helical axis needs a result
  Backdrop backdrop = Backdrop::studio;
  std::function<void(Scene&)> dress;  ///< gives a new scene its looks; may be empty
};

class RunScene {
 public:
  /// Of a start file or a result: both objects at the first flexion, not moved.
  RunScene(const MotionModel& model, const RunSceneOptions& options);

  /// Where a step of the run is: the attitude turns the reference, as in the search.
  void show(const SeenStep& step);
  /// A pose of the result that the scene was made of, from a set of it.
  void show(const JointPose& pose, const Motion& motion);

  const Scene& scene() const { return scene_; }
  const JointPose& pose() const { return pose_; }
  /// Raised when a renderer must load the scene again.
  std::uint64_t n_layouts() const { return n_layouts_; }
  /// Loads it, with room for as many contacts as there may be.
  void load(Renderer& renderer);

  /// What a picture wants room for: the points near the joint at every flexion, moved as now.
  std::vector<Eigen::Vector3d> framed_points() const;

 private:
  void place_bodies(const JointPose& pose, const Motion& motion, const LayerSet& layers);
  LayerSet layers_of_step() const;
  void place_signs(const SeenStep& step);
  void hide_signs();
  void make_room(std::size_t n_contacts);

  RunSceneOptions options_;
  Scene scene_;
  Motion raw_;
  SolverFrame frame_;                    // of the first flexion
  std::vector<Eigen::Vector3d> deltas_;  // [n_flexion]
  double scale_ = 1.0;
  std::optional<JointLayers> layers_;    // all but the signs
  std::size_t points_ = 0, arrows_ = 0;  // drawables
  std::size_t n_signs_ = 0;              // for which there is room
  std::vector<std::uint32_t> point_triangles_, arrow_triangles_;
  JointPose pose_;
  std::uint64_t n_layouts_ = 1;
};

/// Views and panel of a run as a renderer draws them.
struct RunScreenOptions {
  int width = 1280, height = 960;
  RunSceneOptions scene;
  std::vector<RunView> views;  ///< at least one
  double zoom = 1.0;
};

class RunScreen {
 public:
  RunScreen(const MotionModel& model, const RunScreenOptions& options);

  /// The run began anew, maybe with another joint.
  void begin(const MotionModel& model);
  /// The step that the state shows, and its panel with more words. The cameras are set by the first step:
  /// the joint moves, the picture does not.
  void show(const RunState& state, const std::vector<std::string>& lines);
  /// The run is finished: from now on its result is shown, from where one looks.
  void finish(const MotionModel& result);
  /// A pose of the result, from a set of it.
  void show(const RunState& state, const std::vector<std::string>& lines, const JointPose& pose,
            const Motion& motion);
  /// Whether it had another size; show() then.
  bool resize(int width, int height);

  // What a pointer does: each view is looked at alone.
  std::optional<std::size_t> view_at(const Eigen::Vector2d& pointer_px) const;
  Gaze gaze(std::size_t view) const;
  void look(std::size_t view, const Gaze& gaze);
  /// All views as they were in the beginning.
  void reset_views();

  /// Loads what the renderer has not got yet; then its draw() or present() takes the rest.
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
  std::vector<Eigen::Vector3d> pivots_world_mm_;  // one a view
  bool has_step_ = false;                         // the cameras are set
  std::uint64_t n_loaded_layouts_ = 0;
  bool is_font_loaded_ = false;
};

}  // namespace vrda
