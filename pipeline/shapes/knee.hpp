/// The parametric right knee: what its parts agree on, and how each is made.
/// Frames: femur and tibia share canonical axes in the design pose (extension, no varus, the condyles
/// touching the plateaus); the origin is the flexion axis.
#pragma once

#include <functional>

#include "core/mesh.hpp"
#include "shapes/condyle.hpp"
#include "shapes/shapes.hpp"

namespace vrda {

/// The medial condyle: larger, its distal radius 40 mm falling to 23 mm behind.
Condyle medial_condyle();
/// The lateral condyle: smaller, nearly round.
Condyle lateral_condyle();

/// Whole femur and whole tibia as level sets, shafts included, nothing cut.
double femur_field(const Eigen::Vector3d& p_mm);
double tibia_field(const Eigen::Vector3d& p_mm);
double fibula_field(const Eigen::Vector3d& p_mm);

/// Height of the tibia's upper surface (both plateaus and the eminence between them) in the design pose.
double plateau_height_mm(double x_mm, double z_mm);

/// Hides the end of a drawn shaft in its contact part. `depth_mm` tells how far within that part's end plane
/// a point is, `cell_mm` is the edge of a triangle. The shaft stands out by a hair over the part's rounded
/// rim and sinks below its surface further in.
void sink_into_contact_part(Mesh& shaft, const std::function<double(const Eigen::Vector3d&)>& depth_mm,
                            double cell_mm);

/// Where the medial (lateral) condyle rests in the design pose.
Eigen::Vector3d medial_rest_mm();
Eigen::Vector3d lateral_rest_mm();

/// A bone in two: the part that touches, and the shaft that is only drawn.
struct BoneMeshes {
  Mesh contact, shaft;
};

/// A resolution multiplies the number of edges along any line; `drawn_resolution` is that of the shaft.
BoneMeshes femur_meshes(double resolution, double drawn_resolution);
BoneMeshes tibia_meshes(double resolution, double drawn_resolution);
Mesh fibula_mesh(double resolution);
Mesh meniscus_medial_mesh(double resolution);
Mesh meniscus_lateral_mesh(double resolution);

/// How far the moving parts stand below the design pose.
double apart_mm();

/// The right knee with the moving parts lowered by a hair, so that nothing touches.
Shape right_knee(double resolution);

/// Its ligaments, whatever the resolution (knee.cpp has the table and its sources). Attachments lie
/// on the bones' level sets; slack lengths hold for the design pose.
std::vector<ShapeFibre> right_knee_fibres();

/// Where its numbers come from, as comment lines of a table of fibres.
extern const char* const knee_fibre_sources;

}  // namespace vrda
