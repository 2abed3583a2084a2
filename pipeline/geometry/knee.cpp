#include "geometry/knee.hpp"

#include <algorithm>
#include <utility>

#include "geometry/bundle.hpp"
#include "geometry/level_set.hpp"

namespace vrda::geometry {
namespace {

// Drawn-only parts do not benefit from a higher resolution.
constexpr double finest_drawn_resolution = 3.0;

}  // namespace

double initial_clearance_mm()
{
  return 0.5;  // more than the chord errors of two concave surfaces
}

void hide_shaft_end(Mesh& shaft, const std::function<double(const Eigen::Vector3d&)>& depth_mm,
                    double cell_mm)
{
  // The rim is rounded over 2 mm; adjacent triangles and their shading are curved too.
  const double covered_mm = 2.0 + cell_mm;
  const double lift_mm = 0.02 * cell_mm;  // chords of the two parts over the flare differ by less
  // A small slope makes the crossing of the surfaces invisible; it increases once hidden.
  constexpr double slope = 0.03, bend_per_mm = 0.02, deepest_mm = 1.0;
  const double hidden_mm = covered_mm + 1.5 * cell_mm;
  for (Eigen::Index v = 0; v < shaft.vertices_mm.rows(); ++v) {
    const double depth = depth_mm(shaft.vertices_mm.row(v));
    const double further_mm = std::max(0.0, depth - hidden_mm);
    const double sink_mm = slope * std::max(0.0, depth - covered_mm) + bend_per_mm * further_mm * further_mm;
    const double lift = lift_mm * smooth_step(-3.0 * cell_mm, 0.0, depth);
    const double out_mm = lift - std::min(sink_mm, deepest_mm);
    shaft.vertices_mm.row(v) += out_mm * shaft.normals.row(v);
  }
}

Shape right_knee(double resolution)
{
  const double drawn = std::min(resolution, finest_drawn_resolution);
  BoneMeshes femur = femur_meshes(resolution, drawn), tibia = tibia_meshes(resolution, drawn);
  Shape shape;
  shape.reference = {{"femur", "bone", true, std::move(femur.contact)},
                     {"femur_shaft", "bone", false, std::move(femur.shaft)}};
  shape.moving = {{"tibia", "bone", true, std::move(tibia.contact)},
                  {"meniscus_medial", "meniscus", true, meniscus_medial_mesh(resolution)},
                  {"meniscus_lateral", "meniscus", true, meniscus_lateral_mesh(resolution)},
                  {"tibia_shaft", "bone", false, std::move(tibia.shaft)},
                  {"fibula", "bone", false, fibula_mesh(drawn)}};
  for (ShapePart& part : shape.moving) part.mesh.vertices_mm.col(1).array() -= initial_clearance_mm();
  return shape;
}

namespace {

// The bundles follow the anatomy where this model allows; its notch has a lower roof than a real one, so the
// cruciates start from the edge of roof and wall nearest to the flexion axis. In the motion by contact alone
// no strain then exceeds 0.1 from 0 to 90 degrees: PCLal tightens with flexion, ACLpl and the collaterals
// slacken, ACLam and PCLpm change by about a tenth.
std::vector<Bundle> bundles()
{
  return {
      {"ACLam", 3, 4920, -0.112, {-1, -7, 2.3}, {1, -7, 2}, {16, -24, -4}, {16, -24, 0}, tibia_field},
      {"ACLpl", 3, 4920, -0.030, {-4, -7, 5}, {-5, -5.5, 4.5}, {12, -24, 0}, {12, -24, 4}, tibia_field},
      {"PCLal", 3, 4500, -0.020, {-7, -5.5, -7.5}, {-6, -5, -5}, {-14, -27, 1}, {-14, -27, 5}, tibia_field},
      {"PCLpm", 3, 1500, -0.094, {-10, -4, -9}, {-9, -6, -9}, {-14, -31, -5}, {-14, -31, -1}, tibia_field},
      {"MCLs", 4, 3000, 0.047, {0, 6, -42}, {2, 8, -41}, {6, -62, -15}, {12, -66, -12}, tibia_field},
      {"MCLd", 3, 2500, 0.016, {0, 3.5, -42}, {1.5, 3, -42}, {0, -34, -38}, {4, -34, -38}, tibia_field},
      {"MCLp", 3, 2500, 0.030, {-6, 0, -41}, {-5, 1, -41}, {-14, -34, -32}, {-10, -34, -34}, tibia_field},
      {"LCL", 4, 2400, 0.060, {-2, 0, 41}, {0, 4, 41}, {-15, -42, 44}, {-12, -44, 45}, fibula_field},
  };
}

}  // namespace

const char* const knee_fibre_sources =
    "# Ligaments of the generic knee; mm in canonical axes: X anterior, Y proximal, Z to the subject's "
    "right.\n"
    "# Stiffness and reference strain of each bundle, in extension with the condyles on the plateaus, are\n"
    "# those of Lenhart et al. 2015, Ann Biomed Eng 43:2675-2685 (OpenSim-JAM's lenhart2015.osim, means "
    "over\n"
    "# the bundle): ACLam 4920 N -0.112, ACLpl 4920 N -0.030, PCLal 4500 N -0.020, PCLpm 1500 N -0.094,\n"
    "# MCLs 3000 N 0.047, MCLd 2500 N 0.016, MCLp 2500 N 0.030, LCL 2400 N 0.060.\n"
    "# Tension: Blankevoort et al. 1991, J Biomech 24:1019-1031, transition strain 0.06.\n";

std::vector<ShapeFibre> right_knee_fibres()
{
  return fibres_of(bundles(), femur_field, initial_clearance_mm());
}

}  // namespace vrda::geometry
