/// Ties the datasets of add_mechanics() to the members of MotionModel (binding.hpp).
#pragma once

#include "store/layout.hpp"
#include "store/motion_model.hpp"

namespace vrda {

template <typename Push, typename Visitor>
void visit_push(Push& push, Visitor& visit)
{
  visit("/push/delta", push.delta);
  visit("/push/force", push.force_n);
  visit("/push/moment", push.moment_nmm);
  visit("/push/varus_moment", push.varus_moment_nmm);
}

template <typename Paths, typename Visitor>
void visit_contact_paths(Paths& paths, Visitor& visit)
{
  visit("/contact_paths/medial_reference", paths.medial_reference_mm);
  visit("/contact_paths/medial_moving", paths.medial_moving_mm);
  visit("/contact_paths/lateral_reference", paths.lateral_reference_mm);
  visit("/contact_paths/lateral_moving", paths.lateral_moving_mm);
}

template <typename Forces, typename Visitor>
void visit_forces(Forces& forces, Visitor& visit)
{
  visit("/equilibrium/forces/row_start", forces.row_start);
  visit("/equilibrium/forces/point", forces.point_world_mm);
  visit("/equilibrium/forces/normal", forces.normal_world);
  visit("/equilibrium/forces/along_delta", forces.along_delta_n);
  visit("/equilibrium/forces/triangle_reference", forces.triangle_reference);
  visit("/equilibrium/forces/triangle_moving", forces.triangle_moving);
  visit("/equilibrium/forces/compartment", forces.compartment);
}

template <typename Spine, typename Visitor>
void visit_free_spine(Spine& spine, Visitor& visit)
{
  visit("/equilibrium/spine/status", spine.status);
  visit("/equilibrium/spine/varus", spine.varus_deg);
  visit("/equilibrium/spine/tx", spine.tx_mm);
  visit("/equilibrium/spine/ty", spine.ty_mm);
  visit("/equilibrium/spine/tz", spine.tz_mm);
  visit("/equilibrium/spine/theta", spine.theta_deg);
  visit("/equilibrium/spine/energy", spine.energy_nmm);
  visit("/equilibrium/spine/theta_low", spine.theta_low_deg);
  visit("/equilibrium/spine/theta_high", spine.theta_high_deg);
  visit("/equilibrium/spine/n_optima", spine.n_optima);
  visit("/equilibrium/spine/optima_theta_spread", spine.optima_theta_spread_deg);
  visit("/equilibrium/spine/optima_energy_spread", spine.optima_energy_spread_nmm);
}

template <typename Equilibrium, typename Visitor>
void visit_equilibrium(Equilibrium& equilibrium, bool has_compartments, Visitor& visit)
{
  visit("/equilibrium/energy", equilibrium.energy_nmm);
  visit("/equilibrium/balance_residual", equilibrium.balance_residual_n);
  visit("/equilibrium/complementarity", equilibrium.complementarity_mm);
  visit("/equilibrium/worst_gap", equilibrium.worst_gap_mm);
  visit("/equilibrium/flexion_moment", equilibrium.flexion_moment_nmm);
  visit("/equilibrium/varus_moment", equilibrium.varus_moment_nmm);
  if (has_compartments) {
    visit("/equilibrium/force_medial", equilibrium.force_medial_n);
    visit("/equilibrium/force_lateral", equilibrium.force_lateral_n);
  }
  visit_forces(equilibrium.forces, visit);
  visit_free_spine(equilibrium.spine, visit);
}

template <typename Ligaments, typename Visitor>
void visit_ligaments(Ligaments& ligaments, Visitor& visit)
{
  visit("/ligaments/name", ligaments.name);
  visit("/ligaments/bundle", ligaments.bundle);
  visit("/ligaments/reference", ligaments.reference_mm);
  visit("/ligaments/moving", ligaments.moving_mm);
  visit("/ligaments/stiffness", ligaments.stiffness_n);
  visit("/ligaments/slack_length", ligaments.slack_length_mm);
  visit("/ligaments/wrap", ligaments.wrap);
  visit("/ligaments/wrap_name", ligaments.wrap_name);
  visit("/ligaments/wrap_shape", ligaments.wrap_shape);
  visit("/ligaments/wrap_body", ligaments.wrap_body);
  visit("/ligaments/X_body_wrap", ligaments.X_body_wrap);
  visit("/ligaments/wrap_radii", ligaments.wrap_radii_mm);
  visit("/ligaments/length", ligaments.length_mm);
  visit("/ligaments/strain", ligaments.strain);
  visit("/ligaments/tension", ligaments.tension_n);
  visit("/ligaments/energy", ligaments.energy_nmm);
  visit("/ligaments/is_wrapped", ligaments.is_wrapped);
}

/// In the order of add_mechanics(). The model holds a group exactly where `shape` has it.
template <typename Model, typename Visitor>
void visit_mechanics(Model& model, const FileShape& shape, Visitor& visit)
{
  if (shape.minor_version == 0) return;
  visit_push(model.push, visit);
  if (shape.has_compartments) visit_contact_paths(*model.contact_paths, visit);
  if (shape.n_forces) visit_equilibrium(*model.equilibrium, shape.has_compartments, visit);
  if (shape.ligaments) visit_ligaments(*model.ligaments, visit);
}

}  // namespace vrda
