#include "shapes/knee.hpp"

#include <utility>

namespace vrda {
namespace {

// How far the moving parts stand below the design pose: chords of two facetted hollows stay clear of it.
constexpr double apart_mm = 0.5;

}  // namespace

Shape right_knee(double resolution)
{
  Shape shape;
  shape.reference = {{"femur", "bone", true, femur_mesh(resolution)},
                     {"femur_shaft", "bone", false, femur_shaft_mesh(resolution)}};
  shape.moving = {{"tibia", "bone", true, tibia_mesh(resolution)},
                  {"meniscus_medial", "meniscus", true, meniscus_medial_mesh(resolution)},
                  {"meniscus_lateral", "meniscus", true, meniscus_lateral_mesh(resolution)},
                  {"tibia_shaft", "bone", false, tibia_shaft_mesh(resolution)},
                  {"fibula", "bone", false, fibula_mesh(resolution)}};
  for (ShapePart& part : shape.moving) part.mesh.vertices_mm.col(1).array() -= apart_mm;
  return shape;
}

}  // namespace vrda
