/// The layers of joint_layers.hpp: each adds its meshes to the scene once and then updates poses or vertices
/// per frame without allocating. Meshes are in mm; poses take canonical vertices to the scene's frame.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/box_tree.hpp"
#include "model/coordinates.hpp"
#include "model/ligaments.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/scene.hpp"

namespace vrda::view {

/// The reference's canonical axes as arrows from the rotation centre, the flexion and varus axes as rods
/// through it, and Delta as an arrow towards it.
class AxesLayer {
 public:
  AxesLayer(const store::MotionModel& model, Scene& scene);
  /// Updates the poses; the meshes are constant.
  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) const;

 private:
  Side side_ = Side::right;
  Eigen::Vector3d rotation_centre_mm_;
  std::size_t first_drawable_ = 0;
};

/// The helical axis of the moving body relative to the reference from 1 degree of flexion before to 1 degree
/// after, at constant varus, or of a sequence from one frame before to one after: a rod through the axis
/// point nearest to the rotation centre.
class HelicalAxisLayer {
 public:
  HelicalAxisLayer(const store::MotionModel& model, Scene& scene);
  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) const;

 private:
  Eigen::Vector3d rotation_centre_mm_;
  std::size_t drawable_ = 0;
};

/// Canonical axes of the reference, with the axis point nearest to `near_mm`; empty without a pose or
/// rotation.
std::optional<HelicalAxis> helical_axis_at(const store::Motion& motion, const Attitude& attitude,
                                           const Eigen::Vector3d& near_mm);
/// The same around a frame of a sequence.
std::optional<HelicalAxis> helical_axis_at_frame(const store::Motion& motion, double key,
                                                 const Eigen::Vector3d& near_mm);

/// Length of the arrow of a contact without force, for a knee.
inline constexpr double plain_arrow_mm = 9.0;

/// The balls or the arrows of contacts, in a drawable whose number of triangles is constant: unused ones are
/// degenerate.
class ContactMarkers {
 public:
  /// `layer`: contacts (balls) or normals (arrows). `origin_mm`: of the positions.
  ContactMarkers(Scene& scene, Layer layer, ParentFrame parent, const std::string& name,
                 const Eigen::Vector3d& origin_mm = Eigen::Vector3d::Zero());
  /// Sets the largest number of contacts; the renderer must load the scene again.
  void reserve(Scene& scene, std::size_t n_contacts);
  std::size_t capacity() const { return capacity_; }
  void show(Scene& scene, bool is_shown) const;
  /// One contact or more. `arrow_mm`: from tail to tip; not read for balls.
  void place(Scene& scene, std::span<const Eigen::Vector3d> tip_mm, std::span<const Eigen::Vector3d> arrow_mm,
             double scale);

 private:
  bool is_arrows_;
  std::size_t drawable_, capacity_ = 0;
  std::vector<std::uint32_t> triangles_;  ///< of all markers
};

/// The contacts of the nearest grid cell, fixed to the moving object. Balls mark the contact points. Arrows
/// with their tips at the points show the contact forces on the moving object if the equilibrium provides
/// them (length proportional to the force, limited to that of the largest force of the informative cells),
/// otherwise the normals.
class ContactLayer {
 public:
  ContactLayer(const store::MotionModel& model, Scene& scene);
  bool is_empty() const { return points_.tip_mm.empty(); }
  void update(Scene& scene, const store::JointPose& pose, const LayerSet& wanted);

 private:
  /// Markers of one kind in compressed rows: those of cell c are [start[c], start[c + 1]).
  struct Markers {
    std::vector<std::size_t> start;
    std::vector<Eigen::Vector3d> tip_mm;    ///< moving body, from the rotation centre
    std::vector<Eigen::Vector3d> arrow_mm;  ///< from tail to tip
    std::optional<ContactMarkers> drawn;
    std::size_t cell = SIZE_MAX;  ///< the drawn cell
  };
  template <typename Rows, typename Length>
  static Markers markers_of(const store::MotionModel& model, const Rows& rows, const Length& length_mm);
  std::size_t nearest_cell(const store::JointPose& pose) const;

  std::vector<double> flexion_rad_, varus_rad_;
  std::vector<double> keys_;  ///< of a sequence of frames
  double scale_ = 1.0;
  Markers points_, arrows_;
};

/// The centres of contact of both compartments over flexion, as lines on the surfaces of both bodies: of the
/// spine's cells, or of the cells with the least varus.
class ContactPathLayer {
 public:
  ContactPathLayer(const store::MotionModel& model, Scene& scene);
  bool is_empty() const { return drawables_.empty(); }
  void show(Scene& scene) const;

 private:
  std::vector<std::size_t> drawables_;
};

/// The band of an uncertain job: translucent copies of the moving object's contact parts at the poses of the
/// samples at 5 and 95 % (store::quantile_set_names).
class BandLayer {
 public:
  BandLayer(const store::MotionModel& model, Scene& scene);
  bool is_empty() const { return copies_.empty(); }
  void update(Scene& scene, const DisplayedPose& shown) const;

 private:
  struct QuantileCopy {
    store::Motion motion;
    std::vector<std::size_t> drawables;
  };
  std::vector<QuantileCopy> copies_;
};

/// Sheets slightly above the contact surfaces of the moving object oriented along Delta, coloured by the
/// directional gap from each vertex to the reference; hidden where the gap exceeds the range.
class GapLayer {
 public:
  GapLayer(const store::MotionModel& model, Scene& scene);
  bool is_empty() const { return sheets_.empty(); }
  void update(Scene& scene, const store::Motion& motion, const store::JointPose& pose);
  const Legend& legend() const { return legend_; }

 private:
  struct Sheet {
    std::size_t drawable = 0;
    VertexColour bone{};                    ///< the part's colour, into which the map fades
    std::vector<Eigen::Vector3d> point_mm;  ///< [n_vertices] canonical axes of the moving body
    std::vector<double> gap_mm;             ///< [n_vertices] at the last update; infinite beyond the range
    std::vector<std::uint32_t> triangles;   ///< all triangles of the sheet
    bool is_near = false;                   ///< any vertex was within the range at the last update
  };
  void add_sheet(const store::MotionModel& model, Scene& scene, std::size_t component);
  void update_sheet(Drawable& drawable, Sheet& sheet, const Eigen::Vector3d& delta_moving) const;

  Legend legend_;
  Mesh reference_;  ///< contact part
  geometry::BoxTree tree_;
  std::vector<Sheet> sheets_;
  Pose X_reference_moving_ = Pose::Identity();  ///< at the last update
  bool is_made_ = false;
};

/// A flat band along each fibre's path, over its wrap; the width is in the direction in which the bundle's
/// fibres lie side by side.
class LigamentLayer {
 public:
  LigamentLayer(const store::MotionModel& model, Scene& scene);
  bool is_empty() const { return ligaments_.fibres.empty(); }
  void update(Scene& scene, const store::JointPose& pose);
  const Legend& legend() const { return legend_; }
  /// Strain of each fibre at the last update; negative if slack.
  const std::vector<double>& strain() const { return strain_; }

 private:
  model::Ligaments ligaments_;
  Legend legend_;
  Eigen::Vector3d origin_mm_;
  double scale_ = 1.0;
  std::size_t drawable_ = 0;
  std::vector<BandSection> bands_;  ///< [n_fibres] of taut fibres; each end in its body's frame
  std::vector<double> strain_;
  Pose X_reference_moving_ = Pose::Identity();  ///< at the last update
  bool is_made_ = false;
};

/// Where the name of a bone, ligament or compartment is drawn, world.
Eigen::Vector3d place_of(const store::JointLabel& label, const JointFrames& frames);

}  // namespace vrda::view
