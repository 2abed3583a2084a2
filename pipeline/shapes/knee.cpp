#include "shapes/knee.hpp"

#include <algorithm>

namespace vrda {
namespace {

// How far the moving parts stand below the design pose: chords of two facetted hollows stay clear of it.
constexpr double apart_mm = 0.5;

// Drawn-only parts gain nothing from more than this.
constexpr double finest_drawn_resolution = 3.0;

}  // namespace

Shape right_knee(double resolution)
{
  const double drawn = std::min(resolution, finest_drawn_resolution);
  Shape shape;
  shape.reference = {{"femur", "bone", true, femur_mesh(resolution)},
                     {"femur_shaft", "bone", false, femur_shaft_mesh(drawn)}};
  shape.moving = {{"tibia", "bone", true, tibia_mesh(resolution)},
                  {"meniscus_medial", "meniscus", true, meniscus_medial_mesh(resolution)},
                  {"meniscus_lateral", "meniscus", true, meniscus_lateral_mesh(resolution)},
                  {"tibia_shaft", "bone", false, tibia_shaft_mesh(drawn)},
                  {"fibula", "bone", false, fibula_mesh(drawn)}};
  for (ShapePart& part : shape.moving) part.mesh.vertices_mm.col(1).array() -= apart_mm;
  return shape;
}

}  // namespace vrda
