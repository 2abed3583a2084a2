/// Rows of the registry: push, equilibrium, ligaments.
#include "store/registry_rows.hpp"

namespace vrda::store::registry {

// One line per dataset.
// clang-format off

namespace {

void visit_loads(LoadRows& loads, RowVisitor& visit)
{
  const std::string group = "/push/loads";
  const std::vector<std::string> load{group + "/load"}, vectors{"/flexion", group + "/load", "/xyz"};
  visit.group(group);
  visit.dimension(group + "/load", DimensionSize::counted(loads.name.size()));
  visit({group + "/name", load, unit::none, rule(Rule::unique_names), "names of the loads"}, loads.name);
  visit({group + "/frame", load, unit::none, codes(FlagSet::load_frame), "axes in which the load keeps its direction"}, loads.frame);
  visit({group + "/point", {group + "/load", "/xyz"}, unit::mm, number(), "point of application on the moving object at the pose of the meshes, world W"}, loads.point_mm);
  visit({group + "/force", vectors, unit::n, number(), "force on the moving object, axes of its frame"}, loads.force_n);
  visit({group + "/moment", vectors, unit::nmm, number(), "moment on the moving object, right-handed, axes of its frame"}, loads.moment_nmm);
}

void visit_lines(LineRows& lines, RowVisitor& visit)
{
  const std::string group = "/push/lines";
  const std::vector<std::string> line{group + "/line"}, point{group + "/waypoint"};
  visit.group(group);
  visit.dimension(group + "/line", DimensionSize::counted(lines.name.size()));
  visit.dimension(group + "/waypoint", DimensionSize::counted(lines.point_line.size()));
  visit({group + "/name", line, unit::none, rule(Rule::unique_names), "names of the lines of constant tension"}, lines.name);
  visit({group + "/tension", {"/flexion", group + "/line"}, unit::n, at_least_0({}), "tension of the line"}, lines.tension_n);
  visit({group + "/point", {group + "/waypoint", "/xyz"}, unit::mm, number(), "points along the lines, from the reference to the moving object, at the pose of the meshes, world W"}, lines.point_mm);
  visit({group + "/point_line", point, unit::one, row_of(static_cast<Eigen::Index>(lines.name.size())), "row of name"}, lines.point_line);
  visit({group + "/point_body", point, unit::none, codes(FlagSet::body), "body to which the point is fixed"}, lines.point_body);
}

}  // namespace

void visit_push(PushRows& push, RowVisitor& visit)
{
  visit.group("/push");
  visit.attribute("/push", "point_mm", push.point_mm, unit::mm);
  visit({"/push/delta", {"/flexion", "/xyz"}, unit::one, rule(Rule::exact_unit_rows), "unit direction Delta in which the moving object is pushed, world W"}, push.delta);
  visit({"/push/force", {"/flexion", "/xyz"}, unit::n, number(), "force on the moving object, along Delta and across it, world W"}, push.force_n);
  visit({"/push/moment", {"/flexion"}, unit::nmm, number(), "moment on the moving object about Delta, right-knee sign"}, push.moment_nmm);
  visit({"/push/varus_moment", {"/flexion"}, unit::nmm, number(), "moment on the moving object in varus"}, push.varus_moment_nmm);
  if (has_optional(visit, "/push/loads", push.loads)) visit_loads(*push.loads, visit);
  if (has_optional(visit, "/push/lines", push.lines)) visit_lines(*push.lines, visit);
}

namespace {

void visit_forces(MotionModel& model, RowVisitor& visit)
{
  auto& forces = model.equilibrium->forces;
  const std::string group = "/equilibrium/forces";
  const std::size_t n = forces.along_delta_n.size();
  const std::vector<std::string> force{group + "/force"}, vectors{group + "/force", "/xyz"};
  visit.group(group);
  visit.dimension(group + "/force", DimensionSize::counted(n));
  visit.dimension(group + "/cell_bound", DimensionSize::fixed(visit.size("/flexion") * visit.size("/varus") + 1));
  visit({group + "/row_start", {group + "/cell_bound"}, unit::one, row_starts(n), "first force of each cell, cells in the order of the grid, then the number of forces"}, forces.row_start);
  visit({group + "/point", vectors, unit::mm, number(), "point of application, world W"}, forces.point_world_mm);
  visit({group + "/normal", vectors, unit::one, rule(Rule::unit_rows), "unit direction of the force on the moving object, world W"}, forces.normal_world);
  visit({group + "/along_delta", force, unit::n, above_0(), "component of the force opposite to Delta"}, forces.along_delta_n);
  visit({group + "/triangle_reference", force, unit::one, row_of(model.reference.contact.mesh.triangles.rows()), "row of /bodies/reference/triangles"}, forces.triangle_reference);
  visit({group + "/triangle_moving", force, unit::one, row_of(model.moving.contact.mesh.triangles.rows()), "row of /bodies/moving/triangles"}, forces.triangle_moving);
  visit({group + "/compartment", force, unit::none, codes(FlagSet::compartment), "compartment of the force"}, forces.compartment);
}

void visit_branches(SpineBranches& branches, RowVisitor& visit)
{
  const std::string group = "/equilibrium/spine/branches";
  const std::vector<std::string> branch{group + "/branch"};
  visit.group(group);
  visit.dimension(group + "/branch", DimensionSize::counted(branches.energy_nmm.size()));
  visit.dimension(group + "/flexion_bound", DimensionSize::fixed(visit.size("/flexion") + 1));
  visit({group + "/row_start", {group + "/flexion_bound"}, unit::one, row_starts(branches.energy_nmm.size()), "first equilibrium of each flexion, then their number"}, branches.row_start);
  visit({group + "/varus", branch, unit::degree, number(), "varus at equilibrium, adduction positive"}, branches.varus_deg);
  visit_poses(branches, group, branch, number(), visit);
  visit({group + "/energy", branch, unit::nmm, number(), "energy at equilibrium"}, branches.energy_nmm);
  visit({group + "/is_chosen", branch, unit::none, codes(FlagSet::yes_no), "whether it is the pose of the spine"}, branches.is_chosen);
}

void visit_free_spine(FreeSpine& spine, RowVisitor& visit)
{
  const std::string group = "/equilibrium/spine";
  const std::vector<std::string> flexion{"/flexion"};
  const ValueCondition stable = where_stable(spine.status);
  visit.group(group);
  visit({group + "/status", flexion, unit::none, codes(FlagSet::solver_status), "how the motion step with free varus ended"}, spine.status);
  visit({group + "/varus", flexion, unit::degree, number(stable), "varus at equilibrium, adduction positive"}, spine.varus_deg);
  visit_poses(spine, group, flexion, number(stable), visit);
  visit({group + "/energy", flexion, unit::nmm, number(stable), "energy at equilibrium"}, spine.energy_nmm);
  visit({group + "/theta_low", flexion, unit::degree, number_or_nan(stable), "theta under an additional moment of -band_moment_nmm"}, spine.theta_low_deg);
  visit({group + "/theta_high", flexion, unit::degree, number_or_nan(stable), "theta under an additional moment of +band_moment_nmm"}, spine.theta_high_deg);
  visit({group + "/n_optima", flexion, unit::one, count(), "distinct equilibria found from the different starts"}, spine.n_optima);
  visit({group + "/optima_theta_spread", flexion, unit::degree, at_least_0(stable), "largest minus smallest theta of the equilibria"}, spine.optima_theta_spread_deg);
  visit({group + "/optima_energy_spread", flexion, unit::nmm, at_least_0(stable), "largest minus smallest energy of the equilibria"}, spine.optima_energy_spread_nmm);
  visit_branches(spine.branches, visit);
}

}  // namespace

void visit_equilibrium(MotionModel& model, RowVisitor& visit)
{
  auto& found = *model.equilibrium;
  const std::vector<std::string> grid{"/flexion", "/varus"}, vectors{"/flexion", "/varus", "/xyz"};
  const ValueCondition stable = where_stable(model.status);
  visit.group("/equilibrium");
  visit.attribute("/equilibrium", "band_moment_nmm", found.band_moment_nmm, unit::nmm);
  visit({"/equilibrium/energy", grid, unit::nmm, number(stable), "energy of the ligaments minus the work of the loads"}, found.energy_nmm);
  visit({"/equilibrium/balance_residual", grid, unit::n, at_least_0(stable), "residual of the force balance along the free coordinates, moments divided by a lever arm"}, found.balance_residual_n);
  visit({"/equilibrium/complementarity", grid, unit::mm, number(stable), "gaps of the load-bearing features, weighted by their share of the load"}, found.complementarity_mm);
  visit({"/equilibrium/worst_gap", grid, unit::mm, number(stable), "smallest signed gap of any feature, negative is overlap"}, found.worst_gap_mm);
  visit({"/equilibrium/flexion_moment", grid, unit::nmm, number(stable), "moment that holds the flexion of the moving object relative to the reference"}, found.flexion_moment_nmm);
  visit({"/equilibrium/varus_moment", grid, unit::nmm, number(stable), "moment that holds the varus of the moving object relative to the reference"}, found.varus_moment_nmm);
  if (model.has_compartments) {
    visit({"/equilibrium/force_medial", vectors, unit::n, number(stable), "sum of the medial contact forces on the moving object, world W"}, found.force_medial_n);
    visit({"/equilibrium/force_lateral", vectors, unit::n, number(stable), "sum of the lateral contact forces on the moving object, world W"}, found.force_lateral_n);
  }
  visit_forces(model, visit);
  visit_free_spine(found.spine, visit);
}

void visit_coordinates(MotionModel& model, RowVisitor& visit)
{
  auto& found = *model.coordinates;
  const std::string group = "/coordinates", coordinate = group + "/coordinate";
  const ValueCondition stable = where_stable(model.status);
  visit.group(group);
  visit.dimension(coordinate, DimensionSize::fixed(n_joint_coordinates));
  visit.dimension(group + "/rotation", DimensionSize::fixed(3));
  visit.dimension(group + "/translation", DimensionSize::fixed(3));
  visit({group + "/role", {coordinate}, unit::none, codes(FlagSet::coordinate_role), "source of flexion, varus, internal rotation, anterior, proximal and lateral translation"}, found.role);
  visit({group + "/determined", {"/flexion", "/varus", coordinate}, unit::none, codes(FlagSet::optional_yes_no), "whether contacts, fibres and loads determine the free coordinate"}, found.determined);
  visit({group + "/holding_moment", {"/flexion", "/varus", group + "/rotation"}, unit::nmm, number_or_nan(stable), "moment on the moving object that holds the flexion, varus and internal rotation, along the coordinate; NaN where it is free"}, found.holding_moment_nmm);
  visit({group + "/holding_force", {"/flexion", "/varus", group + "/translation"}, unit::n, number_or_nan(stable), "force on the moving object that holds the anterior, proximal and lateral translation, along the coordinate; NaN where it is free"}, found.holding_force_n);
}

namespace {

void visit_wraps(LigamentRows& ligaments, RowVisitor& visit)
{
  const std::vector<std::string> wrap{"/ligaments/wrapping"};
  visit.dimension("/ligaments/wrapping", DimensionSize::counted(ligaments.wrap_name.size()));
  visit({"/ligaments/wrap_name", wrap, unit::none, rule(Rule::names), "names of the wrapping surfaces"}, ligaments.wrap_name);
  visit({"/ligaments/wrap_shape", wrap, unit::none, codes(FlagSet::wrap_shape), "shape of the wrapping surface"}, ligaments.wrap_shape);
  visit({"/ligaments/wrap_body", wrap, unit::none, codes(FlagSet::body), "body to which the wrapping surface is fixed"}, ligaments.wrap_body);
  visit({"/ligaments/X_body_wrap", {"/ligaments/wrapping", "/row", "/column"}, unit::mm, rule(Rule::rigid), "pose taking points of the wrapping surface to canonical axes of its body; the rotation in columns 0 to 2 has no unit"}, ligaments.X_body_wrap);
  visit({"/ligaments/wrap_radii", {"/ligaments/wrapping", "/xyz"}, unit::mm, above_0(), "half-axes of an ellipsoid; radius, radius and half length of a cylinder along its Z"}, ligaments.wrap_radii_mm);
}

}  // namespace

void visit_ligaments(MotionModel& model, RowVisitor& visit)
{
  auto& ligaments = *model.ligaments;
  const std::vector<std::string> fibre{"/ligaments/fibre"}, vectors{"/ligaments/fibre", "/xyz"},
      states{"/flexion", "/varus", "/ligaments/fibre"};
  const ValueCondition stable = where_stable(model.status);
  visit.group("/ligaments");
  visit.attribute("/ligaments", "transition_strain", ligaments.transition_strain);
  visit.dimension("/ligaments/fibre", DimensionSize::counted(ligaments.name.size()));
  visit({"/ligaments/name", fibre, unit::none, rule(Rule::names), "names of the fibres"}, ligaments.name);
  visit({"/ligaments/bundle", fibre, unit::none, rule(Rule::any), "ligament of the fibre"}, ligaments.bundle);
  visit({"/ligaments/reference", vectors, unit::mm, number(), "attachment to the reference body, its canonical axes"}, ligaments.reference_mm);
  visit({"/ligaments/moving", vectors, unit::mm, number(), "attachment to the moving body, its canonical axes"}, ligaments.moving_mm);
  visit({"/ligaments/stiffness", fibre, unit::n, above_0(), "force per unit strain"}, ligaments.stiffness_n);
  visit({"/ligaments/slack_length", fibre, unit::mm, above_0(), "length of zero strain"}, ligaments.slack_length_mm);
  visit({"/ligaments/wrap", fibre, unit::one, row_of(static_cast<Eigen::Index>(ligaments.wrap_name.size()), -1), "row of wrap_name, -1 for none"}, ligaments.wrap);
  visit_wraps(ligaments, visit);
  visit({"/ligaments/length", states, unit::mm, at_least_0(stable), "length of the fibre"}, ligaments.length_mm);
  visit({"/ligaments/strain", states, unit::one, number(stable), "strain of the fibre, negative is slack"}, ligaments.strain);
  visit({"/ligaments/tension", states, unit::n, at_least_0(stable), "tension of the fibre"}, ligaments.tension_n);
  visit({"/ligaments/energy", states, unit::nmm, at_least_0(stable), "energy of the fibre"}, ligaments.energy_nmm);
  visit({"/ligaments/is_wrapped", states, unit::none, codes(FlagSet::optional_yes_no, stable), "whether the fibre is in contact with its wrapping surface"}, ligaments.is_wrapped);
}

// clang-format on
}  // namespace vrda::store::registry
