#include "store/registry.hpp"

#include "store/motion_model_file.hpp"
#include "store/registry_rows.hpp"

namespace vrda::store {

namespace registry {

// One line per dataset.
// clang-format off

namespace {

void visit_root(MotionModel& model, RowVisitor& visit)
{
  visit.attribute("/", "title", model.title);
  visit.attribute("/", "joint", model.joint);
  visit.attribute("/", "side", model.side);
  visit.attribute("/", "method", model.method);
  visit.attribute("/", "rotation_centre_mm", model.rotation_centre_mm, unit::mm);
  visit.attribute("/", "delta", model.delta);
  visit.attribute("/", "contact_resolution_mm", model.contact_resolution_mm, unit::mm);
  visit.attribute("/", "has_compartments", model.has_compartments);
  visit.dimension("/flexion", DimensionSize::axis(model.flexion_deg.size()));
  visit.dimension("/varus", DimensionSize::axis(model.varus_deg.size()));
  visit.dimension("/row", DimensionSize::fixed(4));
  visit.dimension("/column", DimensionSize::fixed(4));
  visit.dimension("/xyz", DimensionSize::fixed(3));
  visit.dimension("/corner", DimensionSize::fixed(3));

  const std::vector<std::string> grid{"/flexion", "/varus"};
  const ValueCondition stable = where_stable(model.status);
  const bool has_frames = has_optional(visit, "/frame", model.frames);
  visit({"/flexion", {"/flexion"}, unit::degree, has_frames ? number() : rule(Rule::axis), "flexion of the attitude"}, model.flexion_deg);
  visit({"/varus", {"/varus"}, unit::degree, rule(Rule::axis), "varus of the attitude, adduction positive"}, model.varus_deg);
  visit_poses(model, "", grid, number(stable), visit);
  visit({"/X_reference_moving", {"/flexion", "/varus", "/row", "/column"}, unit::mm, rule(Rule::rigid, stable), "pose taking stored moving vertices to stored reference vertices; the rotation in columns 0 to 2 has no unit"}, model.X_reference_moving);
  visit({"/status", grid, unit::none, codes(FlagSet::status), "how the motion step ended"}, model.status);
  visit({"/plausibility", grid, unit::none, codes(FlagSet::plausibility), "result of the plausibility check of the stable pose"}, model.plausibility);
  visit({"/iterations", grid, unit::one, count(), "iterations of the motion step"}, model.iterations);
  visit({"/queries", grid, unit::one, count(), "collision and gap queries of the motion step"}, model.queries);
  visit({"/residual", grid, unit::mm, number_or_nan(), "last translation predicted by the solver"}, model.residual_mm);
  visit({"/theta_determined", grid, unit::none, codes(FlagSet::optional_yes_no, stable), "whether the contacts determine the rotation about Delta"}, model.theta_determined);
  visit({"/is_spine", grid, unit::none, codes(FlagSet::yes_no), "whether the cell is on the spine, the continuation path along flexion"}, model.is_spine);
  visit({"/varus_solved", grid, unit::degree, number(stable), "varus of the pose, adduction positive"}, model.varus_solved_deg);
  if (has_frames) {
    visit.attribute("/frame", "key_name", model.frames->key_name);
    visit({"/frame", {"/flexion"}, unit::one, rule(Rule::ascending), "key of the frame: time, percentage of gait, number"}, model.frames->key);
  }
  if (!model.has_compartments) return;
  visit({"/gap_medial_mm", grid, unit::mm, number_or_nan(stable), "remaining gap along Delta in the medial compartment"}, model.gap_medial_mm);
  visit({"/gap_lateral_mm", grid, unit::mm, number_or_nan(stable), "remaining gap along Delta in the lateral compartment"}, model.gap_lateral_mm);
  visit({"/contact_medial", grid, unit::none, codes(FlagSet::optional_yes_no, stable), "whether the medial compartment is in contact"}, model.contact_medial);
  visit({"/contact_lateral", grid, unit::none, codes(FlagSet::optional_yes_no, stable), "whether the lateral compartment is in contact"}, model.contact_lateral);
}

void visit_clinical(MotionModel& model, RowVisitor& visit)
{
  auto& clinical = model.clinical;
  const std::vector<std::string> grid{"/flexion", "/varus"};
  const ValueCondition stable = where_stable(model.status);
  visit.group("/clinical");
  visit({"/clinical/flexion_angle", grid, unit::degree, number(stable), "Grood-Suntay flexion"}, clinical.flexion_deg);
  visit({"/clinical/varus_angle", grid, unit::degree, number(stable), "Grood-Suntay varus, adduction positive"}, clinical.varus_deg);
  visit({"/clinical/internal_rotation", grid, unit::degree, number(stable), "Grood-Suntay internal rotation"}, clinical.internal_rotation_deg);
  visit({"/clinical/anterior", grid, unit::mm, number(stable), "translation of the rotation centre along the floating axis, anterior positive"}, clinical.anterior_mm);
  visit({"/clinical/proximal", grid, unit::mm, number(stable), "translation of the rotation centre along the moving body's long axis, proximal positive"}, clinical.proximal_mm);
  visit({"/clinical/lateral", grid, unit::mm, number(stable), "translation of the rotation centre along the flexion axis, lateral positive"}, clinical.lateral_mm);
}

void visit_contacts(MotionModel& model, RowVisitor& visit)
{
  auto& contacts = model.contacts;
  const std::size_t n = contacts.distance_mm.size();
  const std::vector<std::string> contact{"/contacts/contact"}, vectors{"/contacts/contact", "/xyz"};
  visit.group("/contacts");
  visit.dimension("/contacts/contact", DimensionSize::counted(n));
  visit.dimension("/contacts/cell_bound", DimensionSize::fixed(visit.size("/flexion") * visit.size("/varus") + 1));
  visit({"/contacts/row_start", {"/contacts/cell_bound"}, unit::one, row_starts(n), "first contact of each cell, cells in the order of the grid, then the number of contacts"}, contacts.row_start);
  visit({"/contacts/point", vectors, unit::mm, number(), "point on the reference's surface, world W"}, contacts.point_world_mm);
  visit({"/contacts/normal", vectors, unit::one, rule(Rule::unit_rows), "unit direction of the reaction on the moving object, world W"}, contacts.normal_world);
  visit({"/contacts/distance", contact, unit::mm, number(), "distance of the two surfaces"}, contacts.distance_mm);
  visit({"/contacts/triangle_reference", contact, unit::one, row_of(model.reference.contact.mesh.triangles.rows()), "row of /bodies/reference/triangles"}, contacts.triangle_reference);
  visit({"/contacts/triangle_moving", contact, unit::one, row_of(model.moving.contact.mesh.triangles.rows()), "row of /bodies/moving/triangles"}, contacts.triangle_moving);
  visit({"/contacts/compartment", contact, unit::none, codes(FlagSet::compartment), "compartment of the contact"}, contacts.compartment);
}

void visit_part(Part& part, const std::string& group, const std::string& body, std::size_t n_components,
                RowVisitor& visit)
{
  auto& mesh = part.mesh;
  const std::string vertex = group + "/vertex", triangle = group + "/triangle";
  visit.dimension(vertex, DimensionSize::counted(static_cast<std::size_t>(mesh.vertices_mm.rows())));
  visit.dimension(triangle, DimensionSize::counted(static_cast<std::size_t>(mesh.triangles.rows())));
  visit({group + "/vertices", {vertex, "/xyz"}, unit::mm, number(), "vertices, canonical axes"}, mesh.vertices_mm);
  if (visit.has(group + "/normals", mesh.normals.rows() > 0)) {
    visit({group + "/normals", {vertex, "/xyz"}, unit::one, rule(Rule::unit_or_zero_rows), "outward unit normals of the vertices, canonical axes"}, mesh.normals);
  }
  visit({group + "/triangles", {triangle, "/corner"}, unit::one, row_of(mesh.vertices_mm.rows()), "rows of vertices, counter-clockwise seen from outside"}, mesh.triangles);
  visit({group + "/component", {triangle}, unit::one, row_of(static_cast<Eigen::Index>(n_components)), body == "/bodies/reference" ? "row of /bodies/reference/component_name of each triangle" : "row of /bodies/moving/component_name of each triangle"}, part.component);
}

void visit_body(Body& body, const std::string& group, RowVisitor& visit)
{
  const std::vector<std::string> member{group + "/member"};
  visit.group(group);
  visit.attribute(group, "name", body.name);
  visit.dimension(group + "/member", DimensionSize::counted(body.components.size()));
  visit_column(visit, {group + "/component_name", member, unit::none, rule(Rule::unique_names), "names of the body's components"}, body.components, &Component::name);
  visit_column(visit, {group + "/component_material", member, unit::none, rule(Rule::any), "materials of the body's components"}, body.components, &Component::material);
  visit_part(body.contact, group, group, body.components.size(), visit);
  auto& offset_mm = body.contact.mesh.offset_mm;
  if (visit.has(group + "/offset", !offset_mm.empty())) {
    visit({group + "/offset", {group + "/triangle"}, unit::mm, at_least_0({}), "radius by which the surface of each triangle is rounded outward for gaps, contacts and overlap: a layer that the mesh lacks"}, offset_mm);
  }
  const Mesh& drawn = body.visual.mesh;
  if (!visit.has(group + "/visual", drawn.vertices_mm.rows() > 0 || drawn.triangles.rows() > 0)) return;
  visit.group(group + "/visual");
  visit_part(body.visual, group + "/visual", group, body.components.size(), visit);
}

}  // namespace

void visit_inputs(std::vector<InputFile>& inputs, RowVisitor& visit)
{
  visit_column(visit, {"/job/input_name", {"/job/input"}, unit::none, rule(Rule::any), "input files as the job names them"}, inputs, &InputFile::name);
  visit_column(visit, {"/job/input_sha256", {"/job/input"}, unit::none, rule(Rule::sha256), "SHA-256 of the input files"}, inputs, &InputFile::sha256);
}

namespace {

void visit_scaling(Scaling& scaling, RowVisitor& visit)
{
  const std::string group = "/job/scaling";
  const std::vector<std::string> pair{group + "/pair"};
  visit.group(group);
  visit.attribute(group, "factor", scaling.factor);
  visit.attribute(group, "keeps_steps", scaling.keeps_steps);
  visit.attribute(group, "standard_error", scaling.standard_error);
  visit.attribute(group, "residual_rms_mm", scaling.residual_rms_mm, unit::landmark_mm);
  visit.dimension(group + "/pair", DimensionSize::counted(scaling.landmark.size()));
  visit({group + "/landmark", pair, unit::none, rule(Rule::names), "names of the pairs of landmarks"}, scaling.landmark);
  visit({group + "/model", pair, unit::landmark_mm, above_0(), "distance of each pair in the unscaled model"}, scaling.model_mm);
  visit({group + "/subject", pair, unit::landmark_mm, above_0(), "distance of each pair in the subject"}, scaling.subject_mm);
  visit({group + "/residual", pair, unit::landmark_mm, number(), "the subject's distance minus the factor times the model's"}, scaling.residual_mm);
}

}  // namespace

// clang-format on
}  // namespace registry

void visit_rows(MotionModel& model, RowVisitor& visit)
{
  using namespace registry;
  visit_root(model, visit);
  visit_clinical(model, visit);
  visit.group("/smoothed");
  visit.list("/smoothed", model.smoothed);
  for (auto& set : model.smoothed) visit_smoothed(set, visit);
  visit_contacts(model, visit);
  visit_push(model.push, visit);
  if (model.has_compartments) {
    if (!model.contact_paths) model.contact_paths.emplace();
    visit.group("/contact_paths");
    visit_paths(*model.contact_paths, "/contact_paths", {"/flexion", "/varus", "/xyz"},
                where_stable(model.status), visit);
  }
  if (model.method == "equilibrium") {
    if (!model.equilibrium) model.equilibrium.emplace();
    visit_equilibrium(model, visit);
  }
  if (has_optional(visit, "/coordinates", model.coordinates)) visit_coordinates(model, visit);
  if (has_optional(visit, "/ligaments", model.ligaments)) visit_ligaments(model, visit);
  if (has_optional(visit, "/uncertainty", model.uncertainty))
    visit_uncertainty(*model.uncertainty, model.ligaments.has_value(), visit);
  if (has_optional(visit, "/two_sided", model.two_sided)) visit_two_sided(*model.two_sided, visit);
  if (has_optional(visit, "/default_motion", model.default_motion)) {
    visit.group("/default_motion");
    visit.attribute("/default_motion", "set", model.default_motion->set);
    visit.attribute("/default_motion", "reason", model.default_motion->reason);
  }
  if (has_optional(visit, "/repair", model.repair)) visit_repair(*model.repair, visit);
  if (has_optional(visit, "/zero_varus", model.zero_varus))
    visit_zero_varus(*model.zero_varus, model.has_compartments, visit);
  visit.list("/audit", model.audits);
  if (!model.audits.empty()) visit.group("/audit");
  for (auto& audit : model.audits)
    visit_audit(audit, {model.has_compartments, model.frames.has_value()}, visit);
  visit.group("/bodies");
  visit_body(model.reference, "/bodies/reference", visit);
  visit_body(model.moving, "/bodies/moving", visit);
  if (model.has_compartments) {
    // clang-format off
    visit({"/bodies/moving/compartment", {"/bodies/moving/triangle"}, unit::none, codes(FlagSet::compartment), "compartment of the triangle"}, model.compartment_of_triangle);
    // clang-format on
  }
  visit.group("/job");
  visit.dimension("/job/input", DimensionSize::counted(model.job.inputs.size()));
  visit({"/job/text", {}, unit::none, rule(Rule::any), "the job file as given"}, model.job.text);
  visit({"/job/resolved", {}, unit::none, rule(Rule::any), "every key of the job with its value"},
        model.job.resolved);
  visit_inputs(model.job.inputs, visit);
  if (visit.has("/job/warnings", !model.job.warnings.empty())) {
    visit.dimension("/job/warning", DimensionSize::counted(model.job.warnings.size()));
    visit({"/job/warnings", {"/job/warning"}, unit::none, rule(Rule::names), "warnings about the job"},
          model.job.warnings);
  }
  if (has_optional(visit, "/job/scaling", model.job.scaling)) visit_scaling(*model.job.scaling, visit);
}

}  // namespace vrda::store
