/// Ties the datasets of derived_layout.hpp to the members of MotionModel (binding.hpp).
#pragma once

#include "store/derived_layout.hpp"
#include "store/motion_model.hpp"

namespace vrda {

template <typename Set, typename Visitor>
void visit_smoothed(Set& set, Visitor& visit)
{
  const std::string group = smoothed_group(set.degree);
  visit(group + "/exponents", set.exponents);
  for (auto& surface : set.surfaces) {
    visit(smoothed_path(set.degree, surface.name), surface.values);
    visit(coefficients_path(set.degree, surface.name), surface.coefficients);
  }
  if (set.recontact_mm) visit(group + "/recontact", *set.recontact_mm);
}

template <typename Motion, typename Visitor>
void visit_zero_varus_poses(Motion& motion, Visitor& visit)
{
  visit("/zero_varus/source", motion.source);
  visit("/zero_varus/varus", motion.varus_deg);
  visit("/zero_varus/varus_first", motion.varus_first_deg);
  visit("/zero_varus/varus_last", motion.varus_last_deg);
  visit("/zero_varus/tx", motion.tx_mm);
  visit("/zero_varus/ty", motion.ty_mm);
  visit("/zero_varus/tz", motion.tz_mm);
  visit("/zero_varus/theta", motion.theta_deg);
  visit("/zero_varus/X_reference_moving", motion.X_reference_moving);
  visit("/zero_varus/flexion_angle", motion.clinical_flexion_deg);
  visit("/zero_varus/varus_angle", motion.clinical_varus_deg);
  visit("/zero_varus/internal_rotation", motion.internal_rotation_deg);
  visit("/zero_varus/anterior", motion.anterior_mm);
  visit("/zero_varus/proximal", motion.proximal_mm);
  visit("/zero_varus/lateral", motion.lateral_mm);
}

template <typename Motion, typename Visitor>
void visit_zero_varus(Motion& motion, bool has_compartments, Visitor& visit)
{
  visit_zero_varus_poses(motion, visit);
  if (has_compartments) {
    visit("/zero_varus/medial_reference", motion.medial_reference_mm);
    visit("/zero_varus/medial_moving", motion.medial_moving_mm);
    visit("/zero_varus/lateral_reference", motion.lateral_reference_mm);
    visit("/zero_varus/lateral_moving", motion.lateral_moving_mm);
  }
  visit("/zero_varus/helical_rotation", motion.helical_rotation_deg);
  visit("/zero_varus/helical_translation", motion.helical_translation_mm);
  visit("/zero_varus/helical_direction", motion.helical_direction);
  visit("/zero_varus/helical_point", motion.helical_point_mm);
  visit("/zero_varus/instant_centre", motion.instant_centre_mm);
  if (!has_compartments) return;
  visit("/zero_varus/medial_rolling", motion.medial_rolling_mm);
  visit("/zero_varus/medial_sliding", motion.medial_sliding_mm);
  visit("/zero_varus/lateral_rolling", motion.lateral_rolling_mm);
  visit("/zero_varus/lateral_sliding", motion.lateral_sliding_mm);
}

template <typename Audit, typename Visitor>
void visit_audit(Audit& audit, Visitor& visit)
{
  const std::string group = audit_group(audit.name);
  visit(group + "/flexion", audit.flexion_deg);
  visit(group + "/varus", audit.varus_deg);
  visit(group + "/state", audit.state);
  visit(group + "/gap", audit.gap_mm);
  visit(group + "/penetration", audit.penetration_mm);
}

}  // namespace vrda
