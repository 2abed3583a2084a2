/// The axes that angles turn about, and the axis that the joint turns about.
#pragma once

#include <array>
#include <vector>

#include "core/helical_axis.hpp"
#include "motion/poses.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

namespace vrda {

/// The reference's canonical axes as three arrows from the rotation centre, the axes of flexion and varus as
/// rods through it, and Delta as an arrow up to it.
class AxesLayer {
 public:
  AxesLayer(const MotionModel& model, Scene& scene);
  /// Moves them; their meshes stay.
  void update(Scene& scene, const Motion& motion, const Shown& shown) const;

 private:
  Side side_ = Side::right;
  Eigen::Vector3d rotation_centre_mm_;
  std::size_t first_drawable_ = 0;
};

/// The screw of the moving body over the reference from 1 degree of flexion before to 1 degree after, with
/// the varus held: a rod through the point of the axis nearest to the rotation centre.
class HelicalAxisLayer {
 public:
  HelicalAxisLayer(const MotionModel& model, Scene& scene);
  void update(Scene& scene, const Motion& motion, const Shown& shown) const;

 private:
  Eigen::Vector3d rotation_centre_mm_;
  std::size_t drawable_ = 0;
};

/// In canonical axes of the reference, near `near_mm`; nothing where the set has no pose or does not turn.
std::optional<HelicalAxis> helical_axis_at(const Motion& motion, const Attitude& attitude,
                                           const Eigen::Vector3d& near_mm);

}  // namespace vrda
