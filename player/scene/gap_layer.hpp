/// How close the reference is above the moving object's contact surfaces.
#pragma once

#include <vector>

#include "motion/poses.hpp"
#include "proximity/box_tree.hpp"
#include "scene/palette.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// A sheet a hair above each contact part of the moving object that looks along Delta, coloured by the gap
/// along Delta from each vertex to the reference; nothing of it where the reference is beyond the range.
class GapLayer {
 public:
  GapLayer(const MotionModel& model, Scene& scene);
  bool is_empty() const { return sheets_.empty(); }
  void update(Scene& scene, const Motion& motion, const JointPose& pose);
  const Legend& legend() const { return legend_; }

 private:
  struct Sheet {
    std::size_t drawable = 0;
    VertexColour bone{};                    ///< the part's own colour, which the map fades into
    std::vector<Eigen::Vector3d> point_mm;  ///< [n_vertices] canonical axes of the moving body
    std::vector<double> gap_mm;             ///< [n_vertices] at the last update, infinite beyond the range
    std::vector<std::uint32_t> triangles;   ///< all of them
    bool is_near = false;                   ///< anywhere, at the last update
  };
  void add_sheet(const MotionModel& model, Scene& scene, std::size_t component);
  void update_sheet(Drawable& drawable, Sheet& sheet, const Eigen::Vector3d& delta_moving) const;

  Legend legend_;
  Mesh reference_;  ///< contact part
  BoxTree tree_;
  std::vector<Sheet> sheets_;
  Pose X_reference_moving_ = Pose::Identity();  ///< of the last update
  bool is_made_ = false;
};

}  // namespace vrda
