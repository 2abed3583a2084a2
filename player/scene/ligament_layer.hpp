/// Ligament fibres as tubes, coloured by their strain, thin where they are slack.
#pragma once

#include <vector>

#include "ligament/fibre_path.hpp"
#include "motion/poses.hpp"
#include "scene/palette.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// The fibres in canonical axes of their bodies; none where the model has none.
Ligaments ligaments_of(const MotionModel& model);

class LigamentLayer {
 public:
  LigamentLayer(const MotionModel& model, Scene& scene);
  bool is_empty() const { return ligaments_.fibres.empty(); }
  void update(Scene& scene, const JointPose& pose);
  const Legend& legend() const { return legend_; }
  /// Of each fibre at the last update; negative is slack.
  const std::vector<double>& strain() const { return strain_; }

 private:
  Ligaments ligaments_;
  Legend legend_;
  Eigen::Vector3d origin_mm_;
  double scale_ = 1.0;
  std::size_t drawable_ = 0;
  std::vector<double> strain_;
  Pose X_reference_moving_ = Pose::Identity();  ///< of the last update
  bool is_made_ = false;
};

}  // namespace vrda
