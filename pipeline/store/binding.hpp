/// Ties each dataset of the layout to its member of MotionModel, once, for the writer and the reader.
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "store/derived_binding.hpp"
#include "store/layout.hpp"
#include "store/mechanics_binding.hpp"
#include "store/motion_model.hpp"

namespace vrda {

template <typename APart, typename Visitor>
void visit_part(APart& part, const std::string& group, const PartShape& shape, Visitor& visit)
{
  visit(group + "/vertices", part.mesh.vertices_mm);
  if (shape.has_normals) visit(group + "/normals", part.mesh.normals);
  visit(group + "/triangles", part.mesh.triangles);
  visit(group + "/component", part.component);
}

template <typename ABody, typename Visitor>
void visit_body(ABody& body, const std::string& group, const BodyShape& shape, Visitor& visit)
{
  // The file keeps one column a dataset, the body one struct a component.
  std::vector<std::string> names, materials;
  for (const Component& component : body.components) {
    names.push_back(component.name);
    materials.push_back(component.material);
  }
  visit(group + "/component_name", names);
  visit(group + "/component_material", materials);
  if constexpr (!std::is_const_v<ABody>) {
    body.components.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) body.components[i] = {names[i], materials[i]};
  }
  visit_part(body.contact, group, shape.contact, visit);
  if (shape.has_visual) visit_part(body.visual, group + "/visual", shape.visual, visit);
}

template <typename Inputs, typename Visitor>
void visit_inputs(Inputs& inputs, Visitor& visit)
{
  std::vector<std::string> names, sums;
  for (const InputFile& input : inputs) {
    names.push_back(input.name);
    sums.push_back(input.sha256);
  }
  visit("/job/input_name", names);
  visit("/job/input_sha256", sums);
  if constexpr (!std::is_const_v<Inputs>) {
    inputs.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) inputs[i] = {names[i], sums[i]};
  }
}

template <typename AScaling, typename Visitor>
void visit_scaling(AScaling& scaling, Visitor& visit)
{
  visit("/job/scaling/landmark", scaling.landmark);
  visit("/job/scaling/model", scaling.model_mm);
  visit("/job/scaling/subject", scaling.subject_mm);
  visit("/job/scaling/residual", scaling.residual_mm);
}

template <typename Model, typename Visitor>
void visit_root(Model& model, const FileShape& shape, Visitor& visit)
{
  visit("/flexion", model.flexion_deg);
  visit("/varus", model.varus_deg);
  visit("/tx", model.tx_mm);
  visit("/ty", model.ty_mm);
  visit("/tz", model.tz_mm);
  visit("/theta", model.theta_deg);
  visit("/X_reference_moving", model.X_reference_moving);
  visit("/status", model.status);
  if (shape.minor_version >= 4) visit("/plausibility", model.plausibility);
  visit("/iterations", model.iterations);
  visit("/queries", model.queries);
  visit("/residual", model.residual_mm);
  visit("/theta_determined", model.theta_determined);
  visit("/is_spine", model.is_spine);
  if (shape.minor_version >= 1) visit("/varus_solved", model.varus_solved_deg);
  if (!shape.has_compartments) return;
  visit("/gap_medial_mm", model.gap_medial_mm);
  visit("/gap_lateral_mm", model.gap_lateral_mm);
  visit("/contact_medial", model.contact_medial);
  visit("/contact_lateral", model.contact_lateral);
}

template <typename Clinical, typename Visitor>
void visit_clinical(Clinical& clinical, Visitor& visit)
{
  visit("/clinical/flexion_angle", clinical.flexion_deg);
  visit("/clinical/varus_angle", clinical.varus_deg);
  visit("/clinical/internal_rotation", clinical.internal_rotation_deg);
  visit("/clinical/anterior", clinical.anterior_mm);
  visit("/clinical/proximal", clinical.proximal_mm);
  visit("/clinical/lateral", clinical.lateral_mm);
}

template <typename Contacts, typename Visitor>
void visit_contacts(Contacts& contacts, Visitor& visit)
{
  visit("/contacts/row_start", contacts.row_start);
  visit("/contacts/point", contacts.point_world_mm);
  visit("/contacts/normal", contacts.normal_world);
  visit("/contacts/distance", contacts.distance_mm);
  visit("/contacts/triangle_reference", contacts.triangle_reference);
  visit("/contacts/triangle_moving", contacts.triangle_moving);
  visit("/contacts/compartment", contacts.compartment);
}

/// Calls visit(path, member) for every dataset of layout_of(shape), in its order. `model` is const for
/// writing; for reading, its smoothed sets carry their degrees and names already, its audits their names, and
/// its optional members exist where `shape` has them.
template <typename Model, typename Visitor>
void visit_datasets(Model& model, const FileShape& shape, Visitor&& visit)
{
  visit_root(model, shape, visit);
  visit_clinical(model.clinical, visit);
  for (auto& set : model.smoothed) visit_smoothed(set, visit);
  visit_contacts(model.contacts, visit);
  visit_mechanics(model, shape, visit);
  if (shape.has_zero_varus) visit_zero_varus(*model.zero_varus, shape.has_compartments, visit);
  for (auto& audit : model.audits) visit_audit(audit, visit);
  visit_body(model.reference, "/bodies/reference", shape.reference, visit);
  visit_body(model.moving, "/bodies/moving", shape.moving, visit);
  visit("/job/text", model.job.text);
  visit("/job/resolved", model.job.resolved);
  visit_inputs(model.job.inputs, visit);
  if (shape.n_landmarks) visit_scaling(*model.job.scaling, visit);
}

}  // namespace vrda
