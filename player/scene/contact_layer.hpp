/// Contact points and what presses there.
#pragma once

#include <cstdint>
#include <vector>

#include "motion/poses.hpp"
#include "scene/layer_set.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// The contacts of the nearest cell of the grid, held by the moving object, so that they stay on its surface
/// between cells. Balls where the surfaces touch; arrows that press on the moving object there, their tips at
/// the points: the contact forces where the equilibrium knows them, as long as they are strong (the strongest
/// of the balanced cells sets the scale, no arrow is longer), else the contacts' normals, all alike.
class ContactLayer {
 public:
  ContactLayer(const MotionModel& model, Scene& scene);
  bool is_empty() const { return points_.tip_mm.empty(); }
  void update(Scene& scene, const JointPose& pose, const LayerSet& wanted);

 private:
  /// Solids of one kind; compressed rows: those of cell c are [start[c], start[c + 1]).
  struct Signs {
    std::vector<std::size_t> start;
    std::vector<Eigen::Vector3d> tip_mm;    ///< moving body, from the rotation centre
    std::vector<Eigen::Vector3d> arrow_mm;  ///< from tail to tip
    std::size_t drawable = 0;
    std::vector<std::uint32_t> triangles;  ///< of as many solids as the fullest cell has
    std::size_t cell = SIZE_MAX;           ///< that is drawn
  };
  template <typename Rows, typename Length>
  static Signs signs_of(const MotionModel& model, const Rows& rows, const Length& length_mm);
  std::size_t nearest_cell(const Attitude& attitude) const;
  void update_points(Drawable& drawable);
  void update_arrows(Drawable& drawable);

  std::vector<double> flexion_rad_, varus_rad_;
  double scale_ = 1.0;
  Signs points_, arrows_;
};

}  // namespace vrda
