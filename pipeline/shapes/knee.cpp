#include "shapes/knee.hpp"

#include <algorithm>
#include <utility>

#include "shapes/smooth_ops.hpp"

namespace vrda {
namespace {

// Drawn-only parts gain nothing from more than this.
constexpr double finest_drawn_resolution = 3.0;

}  // namespace

double apart_mm()
{
  return 0.5;  // chords of two facetted hollows stay clear of each other
}

void sink_into_contact_part(Mesh& shaft, const std::function<double(const Eigen::Vector3d&)>& depth_mm,
                            double cell_mm)
{
  // The rim is rounded over 2 mm; triangles beside it bend, and so does their shading.
  const double covered_mm = 2.0 + cell_mm;
  const double lift_mm = 0.02 * cell_mm;  // chords of the two parts over the flare differ by less
  // So flat that the turn where the surfaces cross is not seen; steeper once hidden.
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
  for (ShapePart& part : shape.moving) part.mesh.vertices_mm.col(1).array() -= apart_mm();
  return shape;
}

}  // namespace vrda
