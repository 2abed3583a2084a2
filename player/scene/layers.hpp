/// The layers of joint_layers.hpp, one by one.
#pragma once

#include <cstdint>
#include <vector>

#include "core/clinical.hpp"
#include "ligament/ligaments.hpp"
#include "motion/poses.hpp"
#include "proximity/box_tree.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"
#include "store/motion_model.hpp"

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
