/// Ligament bundles of a generated knee between its bones, given as level sets. In: attachments in mm,
/// canonical axes of the right knee, before projection. Out: fibres with slack lengths for the stated
/// reference strain.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <functional>

#include "geometry/shapes.hpp"
#include "model/mesh.hpp"

namespace vrda::geometry {

/// Attachments of a bundle's fibres are evenly spaced between two points on the femur and two on the tibia
/// (or the fibula's head), projected onto the bone.
struct Bundle {
  const char* name;
  int n_fibres;
  double stiffness_n;       ///< of all its fibres together
  double reference_strain;  ///< of each in the pose of the fields
  Eigen::Vector3d first_femur_mm, last_femur_mm;
  Eigen::Vector3d first_tibia_mm, last_tibia_mm;
  double (*moving_field)(const Eigen::Vector3d&);
};

/// `clearance_mm`: distance of the moving parts below the pose of the fields, to which slack lengths refer.
std::vector<ShapeFibre> fibres_of(const std::vector<Bundle>& bundles,
                                  double (*femur_field)(const Eigen::Vector3d&), double clearance_mm);

// A femoral condyle: a ball swept along a planar spiral, so that distance, lowest points and rolling motion
// are known in closed form.
//
// Sagittal outline by its support function p(a): the extent of the condyle in the direction
// n(a) = (-sin a, -cos a) of the sagittal plane, which points down when the femur is flexed by a. At flexion
// a the condyle's lowest point is (x, y) = (-p'(a), -p(a)) for any shape, and the radius of curvature there
// is p + p''. The radius decreases as
//   r(a) = posterior + extra * u^4,  u = max(0, 1 - a / spiral_end),
// which has the closed-form support function  p = posterior + extra * q(a) - shift . (sin a, cos a)  with
//   q = u^4 - 12 u^2 / e^2 + 24 / e^4  before the spiral's end e, and 24 / e^4 cos(a - e) after it.
// The coronal section is a circle: the surface is swept by a ball of that radius.

struct Condyle {
  double posterior_radius_mm = 20.0;
  double extra_radius_mm = 10.0;                       ///< distal radius minus posterior radius
  double spiral_end_rad = 1.92;                        ///< beyond it the outline is a circle
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< moves the outline in the sagittal plane (X, Y)
  double coronal_radius_mm = 18.0;                     ///< at most posterior_radius_mm
  double z_mm = 0.0;                                   ///< of the condyle's sagittal plane
  double first_rad = -0.5;                             ///< anterior end of the outline
  double last_rad = 2.4;                               ///< posterior end of the outline
};

/// p(a) and p'(a).
struct Support {
  double value_mm = 0.0;
  double slope_mm = 0.0;
};
Support support(const Condyle& condyle, double angle_rad);

double radius_mm(const Condyle& condyle, double angle_rad);

/// Centre of the swept ball where the outline's normal is n(a); its Z is the condyle's.
Eigen::Vector3d ball_centre_mm(const Condyle& condyle, double angle_rad);

/// The swept surface with precomputed samples for fast queries.
class CondyleSurface {
 public:
  explicit CondyleSurface(const Condyle& condyle);

  const Condyle& condyle() const { return condyle_; }

  /// Centre of the swept ball nearest to p (femur's frame).
  Eigen::Vector3d nearest_ball_centre_mm(const Eigen::Vector3d& p_mm) const;

  /// Signed distance; more than 12 mm outside the surface a lower bound.
  double signed_distance_mm(const Eigen::Vector3d& p_mm) const;

  /// Height of the condyle's underside over (x, z) in the femur's frame. Outside the condyle's silhouette:
  /// height of the equator plus the distance from the silhouette.
  double underside_mm(double x_mm, double z_mm) const;

 private:
  /// About 4 degrees apart, so that two steps bracket the minimum.
  static constexpr std::size_t n_samples = 41;

  Condyle condyle_;
  std::array<double, n_samples> angle_rad_{};                    // evenly spaced over the outline
  std::array<double, n_samples> centre_x_mm_{}, centre_y_mm_{};  // of the balls at those angles
  Eigen::Vector3d middle_mm_ = Eigen::Vector3d::Zero();
  double reach_mm_ = 0.0;  // bounding radius of the surface about the middle
};

// The parametric right knee: common geometry of its parts, and their meshes.
// Frames: femur and tibia share canonical axes in the design pose (extension, no varus, the condyles
// touching the plateaus); the origin is the flexion axis.

/// The medial condyle: larger, distal radius 40 mm, posterior radius 23 mm.
Condyle medial_condyle();
/// The lateral condyle: smaller, nearly round.
Condyle lateral_condyle();

/// Complete femur, tibia and fibula as level sets, shafts included.
double femur_field(const Eigen::Vector3d& p_mm);
double tibia_field(const Eigen::Vector3d& p_mm);
double fibula_field(const Eigen::Vector3d& p_mm);

/// Height of the tibia's upper surface (both plateaus and the eminence between them) in the design pose.
double plateau_height_mm(double x_mm, double z_mm);

/// Hides the end of a drawn shaft inside its contact part. `depth_mm` is a point's distance inside that
/// part's end plane, `cell_mm` the edge of a triangle. The shaft is slightly outside over the part's rounded
/// rim and below its surface further in.
void hide_shaft_end(Mesh& shaft, const std::function<double(const Eigen::Vector3d&)>& depth_mm,
                    double cell_mm);

/// Contact point of the medial (lateral) condyle in the design pose.
Eigen::Vector3d medial_contact_point_mm();
Eigen::Vector3d lateral_contact_point_mm();

/// A bone in two meshes: the contact part, and the shaft that is only drawn.
struct BoneMeshes {
  Mesh contact, shaft;
};

/// A resolution is a factor on the number of edges along a line; `drawn_resolution` is for the shaft.
BoneMeshes femur_meshes(double resolution, double drawn_resolution);
BoneMeshes tibia_meshes(double resolution, double drawn_resolution);
Mesh fibula_mesh(double resolution);
Mesh meniscus_medial_mesh(double resolution);
Mesh meniscus_lateral_mesh(double resolution);

/// The patella in front of the generic knee's trochlea in extension, a quarter of a millimetre from it.
double patella_field(const Eigen::Vector3d& p_mm);

/// Where a generated knee has it.
struct PatellaPlace {
  double (*femur)(const Eigen::Vector3d&);  ///< fields of the bones to which its fibres attach
  double (*tibia)(const Eigen::Vector3d&);
  double clearance_mm;                                 ///< by which the moving parts are lowered
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();  ///< from its place in the generic knee
  Eigen::Vector3d tuberosity_shift_mm = Eigen::Vector3d::Zero();
  double tendon_mm = 0.0;                      ///< its fibres run this far in front of the tibia
  Eigen::Vector3d cylinder_mm{4.0, 4.0, 1.0};  ///< that keeps the quadriceps outside the femur
  double cylinder_radius_mm = 30.5;
};
Mesh patella_mesh(double resolution, const PatellaPlace& place);

/// Its tendon, retinacula and lines of the quadriceps as a follower's table, and the cylinders as wraps.
FollowerTexts patella_texts(const PatellaPlace& place, bool is_left);

/// That of the generic knee, in front of its flat tuberosity, and of the knee that `vrda prepare` registers.
PatellaPlace generic_patella();
PatellaPlace template_patella();

/// The point of a level set's surface that Newton steps along the gradient find from `near_mm`.
Eigen::Vector3d on_surface(double (*field)(const Eigen::Vector3d&), const Eigen::Vector3d& near_mm);

/// Distance of the generated moving parts below the design pose.
double initial_clearance_mm();

/// The right knee with the moving parts lowered by initial_clearance_mm(), so that nothing touches.
Shape right_knee(double resolution);

/// Its ligaments, independent of the resolution (table and sources in knee.cpp). Attachments are on the
/// bones' level sets; slack lengths refer to the design pose.
std::vector<ShapeFibre> right_knee_fibres();

/// Sources of the ligament data, as comment lines of a fibre table.
extern const char* const knee_fibre_sources;

/// The knee that `vrda prepare` registers, closer to real knees than the generic one, whose surfaces are made
/// for contact: origin on the flexion axis, extension. Femur and tibia with 50 and 95 mm of bone, cartilage
/// included, and the fibula.
Shape right_template_knee();
std::vector<ShapeFibre> right_template_knee_fibres();
extern const char* const template_knee_fibre_sources;  ///< comment lines of the fibre table

/// Whether a point of its surface is covered by cartilage.
bool is_articular_femur(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal);
bool is_articular_tibia(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal);

}  // namespace vrda::geometry
