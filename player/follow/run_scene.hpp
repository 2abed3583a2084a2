/// The joint as a run moves it, with the contacts of the step on screen.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "follow/run_watch.hpp"
#include "motion/poses.hpp"
#include "render/renderer.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

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

}  // namespace vrda
