/// The parametric right knee: common geometry of its parts, and their meshes.
/// Frames: femur and tibia share canonical axes in the design pose (extension, no varus, the condyles
/// touching the plateaus); the origin is the flexion axis.
#pragma once

#include <functional>

#include "model/mesh.hpp"
#include "geometry/condyle.hpp"
#include "geometry/shapes.hpp"

namespace vrda::geometry {

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
