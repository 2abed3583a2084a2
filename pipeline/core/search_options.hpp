/// The settings of the stability search (DESIGN.md 5.1), in internal units. Defaults: thesis 5.4.
#pragma once

#include "core/units.hpp"

namespace vrda {

enum class ContactPoints { exact, triangle_centre };
enum class ContactNormals { least_curvature, reference, moving };

struct SearchOptions {
  double approach_step_mm = 5.0;
  double translation_step_mm = 1.0;
  double translation_resolution_mm = 0.1;
  double rotation_step_rad = rad_from_deg(1.0);
  double rotation_resolution_rad = rad_from_deg(0.1);
  ContactPoints points = ContactPoints::exact;
  ContactNormals normals = ContactNormals::least_curvature;
  int max_steps = 10000;
};

}  // namespace vrda
