/// Views and panel of a run as a renderer draws them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "follow/run_scene.hpp"
#include "follow/run_state.hpp"
#include "follow/run_views.hpp"
#include "gui/overlay_text.hpp"
#include "view/gaze.hpp"

namespace vrda {

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
