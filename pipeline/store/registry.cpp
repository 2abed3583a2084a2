/// Rows of the registry: data derived from the raw surfaces (smoothed sets, zero-varus motion, audits).
#include "store/registry.hpp"

namespace vrda::store {

using namespace std::string_literals;

namespace registry {

// One line per dataset.
// clang-format off

/// The optional fifth surface, of the varus found, is named `varus_solved` like the raw one: xarray cannot open a
/// `varus` over (flexion, varus).
void visit_surface(SmoothedSurface& surface, const std::string& group, const std::string& dataset, const std::string& term, const Unit& units, RegistryVisitor& visit)
{
  const std::string path = group + "/" + dataset;
  visit({path, {"/flexion", "/varus"}, units, rule(Rule::any), "smoothed surface on the grid"}, surface.values);
  visit({group + "/coefficients_" + dataset, {term}, units, number(), "coefficients of the terms"}, surface.coefficients);
  visit.attribute(path, "n_cells", surface.n_cells);
  visit.attribute(path, "rms", surface.rms, units);
  visit.attribute(path, "largest_residual", surface.largest_residual, units);
  visit.attribute(path, "leave_one_out_rms", surface.leave_one_out_rms, units);
  visit.attribute(path, "condition_number", surface.condition_number);
}

void visit_recontact(std::optional<GridD>& travel_mm, const std::string& group, RegistryVisitor& visit)
{
  if (!has_optional(visit, group + "/recontact", travel_mm)) return;
  visit({group + "/recontact", {"/flexion", "/varus"}, unit::mm, number_or_nan(), "travel along Delta from the smoothed pose into contact"}, *travel_mm);
}

void visit_smoothed_followers(SmoothedSet& set, const std::string& of_set, RegistryVisitor& visit)
{
  if (!visit.has(of_set + "/followers", !set.followers.empty())) return;
  visit.group(of_set + "/followers");
  visit.list(of_set + "/followers", set.followers);
  for (auto& follower : set.followers) {
    const std::string group = of_set + "/followers/" + follower.name;
    visit.group(group);
    if (visit.may_change()) {
      follower.surfaces.resize(n_joint_coordinates);
      for (std::size_t k = 0; k < n_joint_coordinates; ++k) follower.surfaces[k].name = follower_surface_names[k];
    }
    for (std::size_t k = 0; k < follower.surfaces.size(); ++k)
      visit_surface(follower.surfaces[k], group, follower.surfaces[k].name, of_set + "/term", is_rotation(k) ? unit::degree : unit::mm, visit);
    visit_recontact(follower.recontact_mm, group, visit);
  }
}

void visit_smoothed(SmoothedSet& set, RegistryVisitor& visit)
{
  const std::string group = smoothed_group(set.degree);
  visit.group(group);
  visit.derived_attribute(group, "degree", set.degree);
  visit.attribute(group, "is_robust", set.is_robust);
  visit.dimension(group + "/term", DimensionSize::counted(static_cast<std::size_t>(set.exponents.rows())));
  visit.dimension(group + "/axis", DimensionSize::fixed(2));
  visit({group + "/exponents", {group + "/term", group + "/axis"}, unit::one, rule(Rule::any), "degree of each term's Legendre polynomial of flexion and of varus"}, set.exponents);
  const bool has_varus = visit.has(smoothed_path(set.degree, "varus"), set.surfaces.size() == 5);
  if (visit.may_change()) {
    set.surfaces.resize(has_varus ? 5 : 4);
    for (std::size_t i = 0; i < set.surfaces.size(); ++i) set.surfaces[i].name = smoothed_names[i];
  }
  for (auto& surface : set.surfaces) {
    const Unit units = surface.name == "theta" || surface.name == "varus" ? unit::degree : unit::mm;
    visit_surface(surface, group, surface.name == "varus" ? "varus_solved" : surface.name, group + "/term", units, visit);
  }
  visit_recontact(set.recontact_mm, group, visit);
  visit_smoothed_followers(set, group, visit);
}

void visit_two_sided(TwoSided& motion, RegistryVisitor& visit)
{
  const std::string group = "/two_sided";
  const std::vector<std::string> flexion{group + "/flexion"};
  const ValueCondition posed{ValueCondition::When::not_at_code, values_of(motion.contact), code_of(TwoSidedContact::no_pose), "where contact is not no_pose"};
  visit.group(group);
  visit.attribute(group, "degree", motion.degree);
  visit.dimension(group + "/flexion", DimensionSize::axis(motion.flexion_deg.size()));
  visit({group + "/flexion", flexion, unit::degree, rule(Rule::axis), "flexion of the attitude"}, motion.flexion_deg);
  visit({group + "/contact", flexion, unit::none, codes(FlagSet::two_sided_contact), "compartments in contact"}, motion.contact);
  visit({group + "/varus", flexion, unit::degree, number(posed), "varus of the attitude, adduction positive"}, motion.varus_deg);
  visit_poses(motion, group, flexion, number(posed), visit);
  for (const auto& [side, name, meaning] : compartment_names)
    visit({group + "/gap_" + name, flexion, unit::mm, number(posed), "gap along Delta of the "s + name + " compartment"}, motion.gap_mm[side]);
}

void visit_prior(PriorRows& prior, RegistryVisitor& visit)
{
  const std::vector<std::string> flexion{"/flexion"};
  visit.group("/prior");
  visit.attribute("/prior", "statement", prior.statement);
  visit({"/prior/own_stiffness", flexion, unit::nmm_per_radian, number_or_nan(), "stiffness of the joint about Delta without the prior; NaN: not measured"}, prior.own_stiffness);
  visit({"/prior/rotation_share", flexion, unit::one, number_or_nan(), "share of the prior in the stiffness about Delta, and so in the rotation"}, prior.rotation_share);
  visit({"/prior/moment_share", flexion, unit::one, number_or_nan(), "share of the prior in the moments about Delta"}, prior.moment_share);
  visit({"/prior/energy_share", flexion, unit::one, number_or_nan(), "share of the prior in the energy of springs and fibres"}, prior.energy_share);
  visit.group("/prior/terms");
  visit.list("/prior/terms", prior.terms);
  for (PriorTermRows& term : prior.terms) {
    const std::string group = "/prior/terms/" + group_name(term);
    const bool turns = is_angle(static_cast<PriorCoordinate>(term.coordinate));
    const Unit units = turns ? unit::degree : unit::mm;
    visit.group(group);
    visit.attribute(group, "shape", term.shape);
    visit.attribute(group, "level", term.level, units);
    visit.attribute(group, "is_level_free", term.is_level_free);
    visit({group + "/curve", flexion, units, number(), "target of the spring: published curve and level"}, term.curve);
    visit({group + "/value", flexion, units, number_or_nan(), "value of the coordinate at equilibrium"}, term.value);
    visit({group + "/stiffness", flexion, turns ? unit::nmm_per_radian : unit::n_per_mm, above_0(), "stiffness of the spring"}, term.stiffness);
    visit({group + "/force", flexion, turns ? unit::nmm : unit::n, number_or_nan(), "generalised force of the spring on the coordinate"}, term.force);
    visit({group + "/energy", flexion, unit::nmm, number_or_nan(), "energy of the spring"}, term.energy_nmm);
  }
  const std::string group = "/prior/bones_alone";
  BonesAlone& alone = prior.bones_alone;
  const ValueCondition stable = where_stable(alone.status);
  visit.group(group);
  visit({group + "/status", flexion, unit::none, codes(FlagSet::solver_status), "how the motion step without the prior ended"}, alone.status);
  visit({group + "/varus", flexion, unit::degree, number(stable), "varus at equilibrium, adduction positive"}, alone.varus_deg);
  visit_poses(alone, group, flexion, number(stable), visit);
  visit({group + "/energy", flexion, unit::nmm, number(stable), "energy at equilibrium"}, alone.energy_nmm);
  visit({group + "/n_optima", flexion, unit::one, count(), "distinct equilibria found from the different starts"}, alone.n_optima);
}

void visit_repair(RepairedFrames& repair, RegistryVisitor& visit)
{
  const std::string group = "/repair";
  const std::vector<std::string> frame{"/flexion"}, vectors{"/flexion", "/xyz"}, axes{"/xyz"};
  visit.group(group);
  visit.attribute(group, "is_converged", repair.is_converged);
  visit({group + "/X_measured", {"/flexion", "/row", "/column"}, unit::mm, rule(Rule::rigid), "measured pose taking stored moving vertices to stored reference vertices; the rotation in columns 0 to 2 has no unit"}, repair.X_measured);
  visit({group + "/status", frame, unit::none, codes(FlagSet::repair_status), "how the repair of the frame ended"}, repair.status);
  visit({group + "/distance", frame, unit::one, at_least_0({}), "Mahalanobis distance of the repaired from the measured pose"}, repair.distance);
  visit({group + "/rotation_shift", vectors, unit::one, number(), "rotation of the repaired from the measured pose about the canonical axes of the reference, in standard deviations"}, repair.rotation_shift);
  visit({group + "/translation_shift", vectors, unit::one, number(), "displacement of the rotation centre along these axes, in standard deviations"}, repair.translation_shift);
  visit({group + "/gap_before", frame, unit::mm, number_or_nan(), "travel along Delta to the next contact in the measured pose; NaN where it overlaps or nothing is ahead"}, repair.gap_before_mm);
  visit({group + "/gap_after", frame, unit::mm, number_or_nan(), "the same in the repaired pose"}, repair.gap_after_mm);
  visit({group + "/penetration_before", frame, unit::mm, at_least_0({}), "travel opposite to Delta out of the overlap of the measured pose"}, repair.penetration_before_mm);
  visit({group + "/penetration_after", frame, unit::mm, at_least_0({}), "the same in the repaired pose"}, repair.penetration_after_mm);
  visit({group + "/noise_rotation", axes, unit::degree, at_least_0({}), "standard deviation of the measured rotation about each axis"}, repair.noise_deg);
  visit({group + "/noise_translation", axes, unit::mm, at_least_0({}), "standard deviation of the measured displacement along each axis"}, repair.noise_mm);
  visit({group + "/rotation_period", axes, unit::one, at_least_0({}), "period in frames whose amplitude smoothing halves; 2: not smoothed"}, repair.rotation_period);
  visit({group + "/translation_period", axes, unit::one, at_least_0({}), "the same of the displacements"}, repair.translation_period);
  visit.dimension(group + "/side", DimensionSize::counted(repair.gap_limit_mm.size()));
  visit({group + "/gap_limit", {group + "/side"}, unit::mm, number_or_nan(), "largest permitted gap along Delta: of the pair, or medial and lateral; NaN: none"}, repair.gap_limit_mm);
}

namespace {

/// Grood-Suntay numbers: the grids of a model or the rows of the zero-varus motion.
template <typename Values>
void visit_clinical_numbers(OfCoordinates<Values>& values, const std::string& group, const std::vector<std::string>& dimensions, const ValueRule& rule, RegistryVisitor& visit)
{
  constexpr const char* rows[n_joint_coordinates][2] = {{"flexion_angle", "Grood-Suntay flexion"}, {"varus_angle", "Grood-Suntay varus, adduction positive"}, {"internal_rotation", "Grood-Suntay internal rotation"}, {"anterior", "translation of the rotation centre along the floating axis, anterior positive"}, {"proximal", "translation of the rotation centre along the moving body's long axis, proximal positive"}, {"lateral", "translation of the rotation centre along the flexion axis, lateral positive"}};
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    visit({group + '/' + rows[k][0], dimensions, is_rotation(k) ? unit::degree : unit::mm, rule, rows[k][1]}, values[k]);
}

void visit_zero_varus_poses(ZeroVarus& motion, RegistryVisitor& visit)
{
  using When = ValueCondition::When;
  const std::string group = "/zero_varus";
  const std::vector<std::string> flexion{"/flexion"};
  const ValueCondition posed{When::not_at_code, values_of(motion.source), code_of(ZeroVarusSource::none),
                       "where source is not none"};
  const ValueCondition mean{When::at_code, values_of(motion.source), code_of(ZeroVarusSource::both_touch),
                      "where source is both_touch"};
  visit({group + "/source", flexion, unit::none, codes(FlagSet::zero_varus_source), "source of the varus"}, motion.source);
  visit({group + "/varus", flexion, unit::degree, number(posed), "varus of the attitude, adduction positive"}, motion.varus_deg);
  visit({group + "/varus_first", flexion, unit::degree, number(mean), "first varus with both compartments in contact"}, motion.varus_first_deg);
  visit({group + "/varus_last", flexion, unit::degree, number(mean), "last varus with both compartments in contact"}, motion.varus_last_deg);
  visit({group + "/is_cut_off", flexion, unit::none, codes(FlagSet::yes_no), "whether the varus range of the grid cuts off the band with both compartments in contact"}, motion.is_cut_off);
  visit_poses(motion, group, flexion, number(posed), visit);
  visit({group + "/X_reference_moving", {"/flexion", "/row", "/column"}, unit::mm, rule(Rule::rigid, posed), "pose taking stored moving vertices to stored reference vertices; the rotation in columns 0 to 2 has no unit"}, motion.X_reference_moving);
  visit_clinical_numbers(motion.clinical, group, flexion, number(posed), visit);
}

}  // namespace

void visit_zero_varus(ZeroVarus& motion, bool has_compartments, RegistryVisitor& visit)
{
  const std::string group = "/zero_varus";
  const std::vector<std::string> interval{group + "/interval"}, vectors{group + "/interval", "/xyz"};
  visit.group(group);
  visit.attribute(group, "set", motion.set);
  visit_zero_varus_poses(motion, visit);
  const std::int8_t none = code_of(ZeroVarusSource::none);
  const ValueCondition posed{ValueCondition::When::not_at_code, values_of(motion.source), none,
                       "where source is not none"};
  if (has_compartments) visit_paths(motion.centres, group, {"/flexion", "/xyz"}, posed, visit);
  visit.dimension(group + "/interval", DimensionSize::fixed(visit.size("/flexion") - 1));
  visit.dimension(group + "/sagittal", DimensionSize::fixed(2));
  const ValueRule between =
      rule(Rule::whole_rows, {ValueCondition::When::between, values_of(motion.source), none, "between two poses"});
  visit({group + "/helical_rotation", interval, unit::degree, between, "rotation about the finite helical axis"}, motion.helical_rotation_deg);
  visit({group + "/helical_translation", interval, unit::mm, between, "translation along the finite helical axis"}, motion.helical_translation_mm);
  visit({group + "/helical_direction", vectors, unit::one, between, "unit direction of the finite helical axis, canonical axes of the reference body"}, motion.helical_direction);
  visit({group + "/helical_point", vectors, unit::mm, between, "point of the finite helical axis, canonical axes of the reference body"}, motion.helical_point_mm);
  visit({group + "/instant_centre", {group + "/interval", group + "/sagittal"}, unit::mm, between, "instant centre in the sagittal plane: anterior, proximal"}, motion.instant_centre_mm);
  if (!has_compartments) return;
  for (const auto& [side, name, meaning] : compartment_names) {
    visit({group + '/' + name + "_rolling", interval, unit::mm, between, "rolling in the "s + name + " compartment"}, motion.rolling[side].rolling_mm);
    visit({group + '/' + name + "_sliding", interval, unit::mm, between, "sliding in the "s + name + " compartment"}, motion.rolling[side].sliding_mm);
  }
}

template <typename Audit>
void visit_measured(Audit& audit, const std::string& group, const std::vector<std::string>& grid, RegistryVisitor& visit)
{
  using When = ValueCondition::When;
  const ValueCondition free{When::at_code, values_of(audit.state), code_of(AuditState::free), "where state is free"};
  const ValueCondition posed{When::not_at_code, values_of(audit.state), code_of(AuditState::no_pose), "where state is not no_pose"};
  visit({group + "/state", grid, unit::none, codes(FlagSet::audit_state), "result of the audit"}, audit.state);
  visit({group + "/gap", grid, unit::mm, at_least_0(free), "travel along Delta to the next contact"}, audit.gap_mm);
  visit({group + "/penetration", grid, unit::mm, at_least_0(posed), "travel opposite to Delta to the first contact of an approach from far away"}, audit.penetration_mm);
}

void visit_audit(AuditSet& audit, const AuditedModel& model, RegistryVisitor& visit)
{
  using When = ValueCondition::When;
  const std::string group = audit_group(audit.name), flexion = group + "/flexion", varus = group + "/varus";
  const std::vector<std::string> grid{flexion, varus};
  const ValueCondition posed{When::not_at_code, values_of(audit.state), code_of(AuditState::no_pose),
                       "where state is not no_pose"};
  const AuditSummary summary = summary_of(audit);
  visit.group(group);
  visit.attribute(group, "refine", audit.refine);
  visit.derived_attribute(group, "largest_penetration", summary.largest_penetration_mm);
  visit.derived_attribute(group, "largest_gap", summary.largest_gap_mm);
  visit.dimension(flexion, DimensionSize::axis(audit.flexion_deg.size()));
  visit.dimension(varus, DimensionSize::axis(audit.varus_deg.size()));
  visit({flexion, {flexion}, unit::degree, model.has_frames ? number() : rule(Rule::axis), "flexion of the attitude"}, audit.flexion_deg);
  if (model.has_frames) visit({group + "/frame", {flexion}, unit::one, rule(Rule::ascending), "key of the frame, of the model or between two"}, audit.frame_key);
  visit({varus, {varus}, unit::degree, rule(Rule::axis), "varus of the attitude, adduction positive"}, audit.varus_deg);
  visit_measured(audit, group, grid, visit);
  if (visit.has(group + "/followers", !audit.followers.empty())) {
    visit.group(group + "/followers");
    visit.list(group + "/followers", audit.followers);
    for (auto& follower : audit.followers) {
      visit.group(group + "/followers/" + follower.name);
      visit_measured(follower, group + "/followers/" + follower.name, grid, visit);
    }
  }
  if (!model.has_compartments) return;
  for (const auto& [side, name, meaning] : compartment_names)
    visit({group + "/gap_" + name, grid, unit::mm, number_or_nan(posed), "travel along Delta to the first contact of the "s + name + " compartment, negative: overlap"}, audit.compartment_gap_mm[side]);
}

// clang-format on

}  // namespace registry

// Rows of the registry: push, equilibrium, ligaments.

namespace registry {

// One line per dataset.
// clang-format off

namespace {

void visit_loads(LoadRows& loads, RegistryVisitor& visit)
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

void visit_lines(LineRows& lines, RegistryVisitor& visit)
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

void visit_push(PushRows& push, RegistryVisitor& visit)
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

void visit_forces(MotionModel& model, RegistryVisitor& visit)
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

void visit_branches(SpineBranches& branches, RegistryVisitor& visit)
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

void visit_free_spine(FreeSpine& spine, RegistryVisitor& visit)
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

void visit_equilibrium(MotionModel& model, RegistryVisitor& visit)
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
  for (const auto& [side, name, meaning] : compartment_names)
    if (model.has_compartments) visit({"/equilibrium/force_"s + name, vectors, unit::n, number(stable), "sum of the "s + name + " contact forces on the moving object, world W"}, found.force_n[side]);
  visit_forces(model, visit);
  visit_free_spine(found.spine, visit);
}

void visit_coordinates(MotionModel& model, RegistryVisitor& visit)
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

void visit_wraps(LigamentRows& ligaments, const std::string& group, std::size_t n_followers, RegistryVisitor& visit)
{
  const std::string wrapping = group + "/wrapping";
  const std::vector<std::string> wrap{wrapping};
  const bool is_followers = n_followers > 0;
  visit.dimension(wrapping, DimensionSize::counted(ligaments.wrap_name.size()));
  visit({group + "/wrap_name", wrap, unit::none, rule(Rule::names), "names of the wrapping surfaces"}, ligaments.wrap_name);
  visit({group + "/wrap_shape", wrap, unit::none, codes(FlagSet::wrap_shape), "shape of the wrapping surface"}, ligaments.wrap_shape);
  visit({group + "/wrap_body", wrap, is_followers ? unit::one : unit::none, is_followers ? body_number(n_followers) : codes(FlagSet::body), "body to which the wrapping surface is fixed"}, ligaments.wrap_body);
  visit({group + "/X_body_wrap", {wrapping, "/row", "/column"}, unit::mm, rule(Rule::rigid), "pose taking points of the wrapping surface to canonical axes of its body; the rotation in columns 0 to 2 has no unit"}, ligaments.X_body_wrap);
  visit({group + "/wrap_radii", {wrapping, "/xyz"}, unit::mm, above_0(), "half-axes of an ellipsoid; radius, radius and half length of a cylinder along its Z"}, ligaments.wrap_radii_mm);
}

}  // namespace

void visit_ligaments(LigamentRows& ligaments, const std::string& group, const GridB& status, std::size_t n_followers,
                     RegistryVisitor& visit)
{
  const std::string fibres = group + "/fibre";
  const std::vector<std::string> fibre{fibres}, vectors{fibres, "/xyz"}, states{"/flexion", "/varus", fibres};
  const ValueCondition stable = where_stable(status);
  const bool is_followers = n_followers > 0;
  visit.group(group);
  visit.attribute(group, "transition_strain", ligaments.transition_strain);
  visit.dimension(fibres, DimensionSize::counted(ligaments.name.size()));
  visit({group + "/name", fibre, unit::none, rule(Rule::names), "names of the fibres"}, ligaments.name);
  visit({group + "/bundle", fibre, unit::none, rule(Rule::any), "ligament of the fibre"}, ligaments.bundle);
  visit({group + "/reference", vectors, unit::mm, number(), is_followers ? "attachment to the body in from_body, its canonical axes" : "attachment to the reference body, its canonical axes"}, ligaments.reference_mm);
  visit({group + "/moving", vectors, unit::mm, number(), is_followers ? "attachment to the body in to_body, its canonical axes" : "attachment to the moving body, its canonical axes"}, ligaments.moving_mm);
  visit({group + "/stiffness", fibre, unit::n, is_followers ? at_least_0({}) : above_0(), "force per unit strain"}, ligaments.stiffness_n);
  visit({group + "/slack_length", fibre, unit::mm, above_0(), "length of zero strain"}, ligaments.slack_length_mm);
  visit({group + "/wrap", fibre, unit::one, row_of(static_cast<Eigen::Index>(ligaments.wrap_name.size()), -1), "row of wrap_name, -1 for none"}, ligaments.wrap);
  if (is_followers) {
    visit({group + "/from_body", fibre, unit::one, body_number(n_followers), "body of the first attachment: 0 the reference, 1 the moving body, then followers by their attribute body_index"}, ligaments.from_body);
    visit({group + "/to_body", fibre, unit::one, body_number(n_followers), "body of the second attachment"}, ligaments.to_body);
    visit({group + "/constant_tension", fibre, unit::n, at_least_0({}), "tension of a line of constant tension; 0: an elastic fibre"}, ligaments.constant_tension_n);
  }
  visit_wraps(ligaments, group, n_followers, visit);
  visit({group + "/length", states, unit::mm, at_least_0(stable), "length of the fibre"}, ligaments.length_mm);
  visit({group + "/strain", states, unit::one, number(stable), "strain of the fibre, negative is slack"}, ligaments.strain);
  visit({group + "/tension", states, unit::n, at_least_0(stable), "tension of the fibre"}, ligaments.tension_n);
  visit({group + "/energy", states, unit::nmm, at_least_0(stable), "energy of the fibre"}, ligaments.energy_nmm);
  visit({group + "/is_wrapped", states, unit::none, codes(FlagSet::optional_yes_no, stable), "whether the fibre is in contact with its wrapping surface"}, ligaments.is_wrapped);
}

// clang-format on

}  // namespace registry

// Rows of the registry: the motion of an uncertain job.

namespace registry {

// One line per dataset.
// clang-format off

namespace {

void visit_shares(UncertainPose& of, const std::vector<std::string>& table, const std::string& group, RegistryVisitor& visit)
{
  const auto at_least_minus_1 = ValueRule{.rule = Rule::number_or_nan, .least = -1.0};
  const auto at_least_0_or_nan = ValueRule{.rule = Rule::number_or_nan, .least = 0.0};
  visit({group + "/rank_correlation", table, unit::one, at_least_minus_1, "Spearman's rank correlation of each result with each draw"}, of.rank_correlation);
  visit({group + "/first_order", table, unit::one, at_least_0_or_nan, "first-order Sobol index: share of the variance that the draw explains alone"}, of.first_order);
  visit({group + "/first_order_low", table, unit::one, at_least_0_or_nan, "lower end of its 90 % interval"}, of.first_order_low);
  visit({group + "/first_order_high", table, unit::one, at_least_0_or_nan, "upper end of its 90 % interval"}, of.first_order_high);
}

// In the dimensions of the samples of the joint.
void visit_uncertain_follower(UncertainFollower& of, const std::string& samples, RegistryVisitor& visit)
{
  const std::string group = samples + "/followers/" + of.name;
  const std::string sample = samples + "/sample", band = samples + "/quantile", angle = samples + "/angle", direction = samples + "/direction";
  const ValueCondition stable = where_stable(of.status);
  visit.group(group);
  visit.dimension(group + "/quantity", DimensionSize::fixed(static_cast<std::int64_t>(n_joint_coordinates)));
  visit({group + "/status", {sample, "/flexion"}, unit::none, codes(FlagSet::solver_status), "how the step of the follower ended; that of the joint where the joint has no pose"}, of.status);
  visit({group + "/rotation", {sample, "/flexion", angle}, unit::degree, number(stable), "flexion, rotation and tilt of the follower in each sample"}, of.rotation_deg);
  visit({group + "/translation", {sample, "/flexion", direction}, unit::mm, number(stable), "anterior, proximal and lateral displacement of its centre in each sample"}, of.translation_mm);
  visit({group + "/n_solved", {"/flexion"}, unit::one, count(), "samples with a stable pose of the follower"}, of.n_solved);
  visit({group + "/rotation_band", {band, "/flexion", angle}, unit::degree, number_or_nan(), "quantiles of the rotations"}, of.rotation_band_deg);
  visit({group + "/translation_band", {band, "/flexion", direction}, unit::mm, number_or_nan(), "quantiles of the displacements"}, of.translation_band_mm);
  visit_shares(of, {"/flexion", group + "/quantity", samples + "/draw"}, group, visit);
}

}  // namespace

void visit_uncertainty(UncertainMotion& motion, bool has_fibres, RegistryVisitor& visit)
{
  const std::string group = "/uncertainty";
  const std::string sample = group + "/sample", draw = group + "/draw", band = group + "/quantile";
  const ValueCondition stable = where_stable(motion.status);
  const auto at_least_0_or_nan = ValueRule{.rule = Rule::number_or_nan, .least = 0.0};
  visit.group(group);
  visit.attribute(group, "sequence", motion.sequence);
  visit.attribute(group, "seed", motion.seed);
  visit.dimension(draw, DimensionSize::counted(motion.draw.size()));
  visit.dimension(sample, DimensionSize::counted(motion.n_samples()));
  visit.dimension(group + "/angle", DimensionSize::fixed(3));
  visit.dimension(group + "/direction", DimensionSize::fixed(3));
  visit.dimension(group + "/compartment", DimensionSize::fixed(3));
  visit.dimension(band, DimensionSize::fixed(static_cast<std::int64_t>(band_probabilities.size())));
  visit.dimension(group + "/quantity", DimensionSize::fixed(static_cast<std::int64_t>(uncertain_quantities.size())));
  // netCDF finds dimensions in a group and those above it, so not in /ligaments.
  if (has_fibres) visit.dimension(group + "/fibre", DimensionSize::fixed(static_cast<std::int64_t>(visit.size("/ligaments/fibre"))));
  const std::vector<std::string> poses{sample, "/flexion"}, table{"/flexion", group + "/quantity", draw};
  const auto of_sample = [&](const char* of) { return std::vector<std::string>{sample, "/flexion", group + of}; };
  const auto of_band = [&](const std::string& of) { return std::vector<std::string>{band, "/flexion", of}; };
  visit({group + "/draw_name", {draw}, unit::none, rule(Rule::unique_names), "names of the independent draws"}, motion.draw);
  visit({group + "/quantity_name", {group + "/quantity"}, unit::none, rule(Rule::unique_names), "names of the results"}, motion.quantity);
  visit({group + "/probability", {band}, unit::one, ValueRule{.rule = Rule::number, .least = 0.0, .largest = 1.0}, "probabilities of the bands: smallest, 5 %, median, 95 %, largest"}, motion.probability);
  visit({group + "/value", {sample, draw}, unit::one, number(), "value of each draw: a factor, a change in the unit of its quantity, or a standard normal score"}, motion.value);
  visit({group + "/status", poses, unit::none, codes(FlagSet::solver_status), "how the motion step of the sample ended"}, motion.status);
  visit({group + "/rotation", of_sample("/angle"), unit::degree, number(stable), "Grood-Suntay flexion, varus and internal rotation of each sample"}, motion.rotation_deg);
  visit({group + "/translation", of_sample("/direction"), unit::mm, number(stable), "anterior, proximal and lateral translation of each sample, of the job's rotation centre"}, motion.translation_mm);
  visit({group + "/contact_force", of_sample("/compartment"), unit::n, at_least_0_or_nan, "resultant contact force of each sample: all, medial, lateral"}, motion.contact_force_n);
  visit({group + "/n_solved", {"/flexion"}, unit::one, count(), "samples with a stable pose"}, motion.n_solved);
  visit({group + "/rotation_band", of_band(group + "/angle"), unit::degree, number_or_nan(), "quantiles of the rotations"}, motion.rotation_band_deg);
  visit({group + "/translation_band", of_band(group + "/direction"), unit::mm, number_or_nan(), "quantiles of the translations"}, motion.translation_band_mm);
  visit({group + "/contact_force_band", of_band(group + "/compartment"), unit::n, at_least_0_or_nan, "quantiles of the contact forces"}, motion.contact_force_band_n);
  if (has_fibres) visit({group + "/tension_band", of_band(group + "/fibre"), unit::n, at_least_0_or_nan, "quantiles of the tensions of the fibres"}, motion.tension_band_n);
  const std::vector<std::string> motions{band, "/flexion"};
  const ValueCondition posed = where_stable(motion.quantile_status);
  visit({group + "/quantile_sample", {band}, unit::one, row_of(static_cast<Eigen::Index>(visit.size(sample))), "sample at each probability in the order of internal rotation, as mean over flexion"}, motion.quantile_sample);
  visit({group + "/quantile_status", motions, unit::none, codes(FlagSet::solver_status), "how the motion step of that sample ended"}, motion.quantile_status);
  visit({group + "/tx", motions, unit::mm, number(posed), "translation of that sample along X of the world frame W"}, motion.tx_mm);
  visit({group + "/ty", motions, unit::mm, number(posed), "translation of that sample along Y of the world frame W"}, motion.ty_mm);
  visit({group + "/tz", motions, unit::mm, number(posed), "translation of that sample along Z of the world frame W"}, motion.tz_mm);
  visit({group + "/theta", motions, unit::degree, number(posed), "rotation of that sample about Delta, right-knee sign"}, motion.theta_deg);
  visit({group + "/varus", motions, unit::degree, number(posed), "varus of that sample, adduction positive"}, motion.varus_deg);
  visit_shares(motion, table, group, visit);
  if (!visit.has(group + "/followers", !motion.followers.empty())) return;
  visit.group(group + "/followers");
  visit.list(group + "/followers", motion.followers);
  for (UncertainFollower& follower : motion.followers) visit_uncertain_follower(follower, group, visit);
}

// clang-format on

}  // namespace registry

namespace registry {

// One line per dataset.
// clang-format off

namespace {

void visit_root(MotionModel& model, RegistryVisitor& visit)
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
  for (const auto& [side, name, meaning] : compartment_names)
    visit({"/gap_"s + name + "_mm", grid, unit::mm, number_or_nan(stable), "remaining gap along Delta in the "s + name + " compartment"}, model.gap_mm[side]);
  for (const auto& [side, name, meaning] : compartment_names)
    visit({"/contact_"s + name, grid, unit::none, codes(FlagSet::optional_yes_no, stable), "whether the "s + name + " compartment is in contact"}, model.is_in_contact[side]);
}

void visit_clinical(MotionModel& model, RegistryVisitor& visit)
{
  const std::vector<std::string> grid{"/flexion", "/varus"};
  const ValueCondition stable = where_stable(model.status);
  visit.group("/clinical");
  visit_clinical_numbers(model.clinical, "/clinical", grid, number(stable), visit);
}

void visit_contacts(MotionModel& model, RegistryVisitor& visit)
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
                RegistryVisitor& visit)
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
  visit({group + "/component", {triangle}, unit::one, row_of(static_cast<Eigen::Index>(n_components)), body == "/bodies/reference" ? "row of /bodies/reference/component_name of each triangle" : body == "/bodies/moving" ? "row of /bodies/moving/component_name of each triangle" : "row of the body's component_name of each triangle"}, part.component);
}

void visit_body(Body& body, const std::string& group, RegistryVisitor& visit)
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
  auto& overlap_mm = body.contact.mesh.overlap_mm;
  if (visit.has(group + "/overlap", !overlap_mm.empty())) {
    visit({group + "/overlap", {group + "/triangle"}, unit::mm, at_least_0({}), "depth to which the other object may be inside the surface along the normal of each triangle: gaps, contact flags and penetration are measured from there"}, overlap_mm);
  }
  const Mesh& drawn = body.visual.mesh;
  if (!visit.has(group + "/visual", drawn.vertices_mm.rows() > 0 || drawn.triangles.rows() > 0)) return;
  visit.group(group + "/visual");
  visit_part(body.visual, group + "/visual", group, body.components.size(), visit);
}

// As those of the equilibrium, in canonical axes of the body whose frame the follower's coordinates use.
void visit_follower_forces(FollowerRows& follower, const std::string& of_follower, RegistryVisitor& visit)
{
  auto& forces = follower.forces;
  const std::string group = of_follower + "/contacts";
  const std::size_t n = forces.along_delta_n.size();
  const std::vector<std::string> force{group + "/force"}, vectors{group + "/force", "/xyz"};
  visit.group(group);
  visit.dimension(group + "/force", DimensionSize::counted(n));
  visit.dimension(group + "/cell_bound", DimensionSize::fixed(visit.size("/flexion") * visit.size("/varus") + 1));
  visit({group + "/row_start", {group + "/cell_bound"}, unit::one, row_starts(n), "first contact force of each cell, cells in the order of the grid, then the number of forces"}, forces.row_start);
  visit({group + "/point", vectors, unit::mm, number(), "point of the contact, canonical axes of the body in the attribute of"}, forces.point_world_mm);
  visit({group + "/normal", vectors, unit::one, rule(Rule::unit_rows), "unit direction of the force on the follower, in the same axes"}, forces.normal_world);
  visit({group + "/along_delta", force, unit::n, above_0(), "share of the force along the follower's Delta"}, forces.along_delta_n);
  visit({group + "/triangle_touched", force, unit::one, count(), "triangle of what it touches, the contact triangles of the bodies in touches one after the other"}, forces.triangle_reference);
  visit({group + "/triangle", force, unit::one, row_of(follower.body.contact.mesh.triangles.rows()), "row of body/triangles"}, forces.triangle_moving);
}

}  // namespace

void visit_follower(FollowerRows& follower, const MotionModel& model, RegistryVisitor& visit)
{
  const std::size_t n_followers = model.followers.size();
  const std::string group = "/followers/" + follower.name;
  const std::vector<std::string> grid{"/flexion", "/varus"};
  const ValueCondition stable = where_stable(follower.status);
  // A measured pose is no equilibrium.
  const bool is_measured = model.method == "import";
  const ValueRule balance = is_measured ? number_or_nan() : number(stable), residual = is_measured ? number_or_nan() : at_least_0(stable);
  visit.group(group);
  visit.attribute(group, "body_index", follower.body_index);
  visit.attribute(group, "of", follower.of);
  visit.attribute(group, "centre_mm", follower.centre_mm, unit::mm);
  visit.attribute(group, "delta", follower.delta);
  visit.attribute(group, "push_n", follower.push_n, unit::n);
  visit.attribute(group, "has_reaction", follower.has_reaction);
  visit.dimension(group + "/touched", DimensionSize::counted(follower.touches.size()));
  visit({group + "/touches", {group + "/touched"}, unit::one, body_number(n_followers), "bodies that it may touch, by their number"}, follower.touches);
  if (visit.has(group + "/touches_drawn", !follower.touches_drawn.empty()))
    visit({group + "/touches_drawn", {group + "/touched"}, unit::none, codes(FlagSet::yes_no), "whether it may also touch the drawn parts of that body"}, follower.touches_drawn);
  visit({group + "/status", grid, unit::none, codes(FlagSet::status), "how the step of the follower ended; that of the joint where the joint has no pose"}, follower.status);
  if (visit.has(group + "/plausibility", follower.plausibility.size() > 0))
    visit({group + "/plausibility", grid, unit::none, codes(FlagSet::plausibility), "result of the plausibility check of its stable pose"}, follower.plausibility);
  const char* meanings[] = {"flexion of the follower", "rotation about the floating axis, as varus of the joint", "rotation about the follower's long axis, as internal rotation of the joint", "anterior displacement of its centre in the body of its coordinates", "proximal displacement of its centre", "lateral displacement of its centre"};
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    visit({group + "/" + follower_surface_names[k], grid, is_rotation(k) ? unit::degree : unit::mm, number(stable), meanings[k]}, follower.coordinates[k]);
  visit({group + "/X_of_follower", {"/flexion", "/varus", "/row", "/column"}, unit::mm, rule(Rule::rigid, stable), "pose taking stored vertices of the follower to those of the body of its coordinates; the rotation in columns 0 to 2 has no unit"}, follower.X_of_follower);
  visit({group + "/iterations", grid, unit::one, count(), "iterations of the step"}, follower.iterations);
  visit({group + "/queries", grid, unit::one, count(), "gap queries of the step"}, follower.queries);
  visit({group + "/energy", grid, unit::nmm, balance, "energy of its fibres, lines and springs minus the work of its push"}, follower.energy_nmm);
  visit({group + "/balance_residual", grid, unit::n, residual, "residual of the force balance, moments divided by a lever arm"}, follower.balance_residual_n);
  visit({group + "/complementarity", grid, unit::mm, balance, "gaps of the load-bearing features, weighted by their share of the load"}, follower.complementarity_mm);
  visit({group + "/worst_gap", grid, unit::mm, balance, "smallest signed gap of any feature along its Delta, negative is overlap"}, follower.worst_gap_mm);
  visit_body(follower.body, group + "/body", visit);
  visit_follower_forces(follower, group, visit);
  if (has_optional(visit, group + "/ligaments", follower.ligaments)) visit_ligaments(*follower.ligaments, group + "/ligaments", follower.status, n_followers, visit);
}

void visit_inputs(std::vector<InputFile>& inputs, RegistryVisitor& visit)
{
  visit_column(visit, {"/job/input_name", {"/job/input"}, unit::none, rule(Rule::any), "input files as the job names them"}, inputs, &InputFile::name);
  visit_column(visit, {"/job/input_sha256", {"/job/input"}, unit::none, rule(Rule::sha256), "SHA-256 of the input files"}, inputs, &InputFile::sha256);
}

namespace {

void visit_scaling(Scaling& scaling, RegistryVisitor& visit)
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

void visit_registry(MotionModel& model, RegistryVisitor& visit)
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
  if (has_optional(visit, "/ligaments", model.ligaments))
    visit_ligaments(*model.ligaments, "/ligaments", model.status, 0, visit);
  if (has_optional(visit, "/uncertainty", model.uncertainty))
    visit_uncertainty(*model.uncertainty, model.ligaments.has_value(), visit);
  if (has_optional(visit, "/prior", model.prior)) visit_prior(*model.prior, visit);
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
  if (visit.has("/followers", !model.followers.empty())) {
    visit.group("/followers");
    visit.list("/followers", model.followers);
    for (FollowerRows& follower : model.followers) visit_follower(follower, model, visit);
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

namespace registry {

// One line per dataset.
// clang-format off

namespace {

void visit_searches(Trace& trace, RegistryVisitor& visit)
{
  auto& searches = trace.searches;
  const std::vector<std::string> search{"/searches/search"}, vectors{"/searches/search", "/xyz"};
  visit.group("/searches");
  visit.dimension("/searches/search", DimensionSize::counted(searches.node.size()));
  visit.dimension("/searches/search_bound", DimensionSize::fixed(visit.size("/searches/search") + 1));
  visit({"/searches/flexion", search, unit::degree, number(), "flexion of the attitude"}, searches.flexion_deg);
  visit({"/searches/varus", search, unit::degree, number(), "varus of the attitude, adduction positive"}, searches.varus_deg);
  visit({"/searches/node", search, unit::none, codes(FlagSet::node), "kind of node of the seeding graph"}, searches.node);
  visit({"/searches/status", search, unit::none, codes(FlagSet::search_status), "how the search ended"}, searches.status);
  visit({"/searches/seed_translation", vectors, unit::mm, number(), "translation of the seed, world W"}, searches.seed_translation_mm);
  visit({"/searches/seed_theta", search, unit::degree, number(), "rotation of the seed about Delta, right-knee sign"}, searches.seed_theta_deg);
  visit({"/searches/move_start", {"/searches/search_bound"}, unit::one, row_starts(trace.moves.kind.size()), "first move of each search, then the number of moves"}, searches.move_start);
}

void visit_moves(Trace& trace, RegistryVisitor& visit)
{
  auto& moves = trace.moves;
  const std::vector<std::string> move{"/moves/move"}, vectors{"/moves/move", "/xyz"};
  visit.group("/moves");
  visit.dimension("/moves/move", DimensionSize::counted(moves.kind.size()));
  visit.dimension("/moves/move_bound", DimensionSize::fixed(visit.size("/moves/move") + 1));
  visit({"/moves/iteration", move, unit::one, count(), "iteration of the search"}, moves.iteration);
  visit({"/moves/kind", move, unit::none, codes(FlagSet::move_kind), "kind of the move"}, moves.kind);
  visit({"/moves/translation", vectors, unit::mm, number(), "translation after the move, world W"}, moves.translation_mm);
  visit({"/moves/theta", move, unit::degree, number(), "rotation about Delta after the move, right-knee sign"}, moves.theta_deg);
  visit({"/moves/translation_step", move, unit::mm, number(), "current translation step"}, moves.translation_step_mm);
  visit({"/moves/rotation_step", move, unit::degree, number(), "current rotation step"}, moves.rotation_step_deg);
  visit({"/moves/collides", move, unit::none, codes(FlagSet::yes_no), "whether a trial of a bisection was blocked"}, moves.collides);
  visit({"/moves/is_cycle", move, unit::none, codes(FlagSet::yes_no), "whether the search visited this pose before"}, moves.is_cycle);
  visit({"/moves/in_contact", move, unit::none, codes(FlagSet::yes_no), "whether the approach ended in contact"}, moves.in_contact);
  visit({"/moves/contact_start", {"/moves/move_bound"}, unit::one, row_starts(trace.contacts.compartment.size()), "first contact of each move, then the number of contacts"}, moves.contact_start);
}

void visit_trace_contacts(TraceContacts& contacts, RegistryVisitor& visit)
{
  const std::vector<std::string> contact{"/contacts/contact"}, vectors{"/contacts/contact", "/xyz"};
  visit.group("/contacts");
  visit.dimension("/contacts/contact", DimensionSize::counted(contacts.compartment.size()));
  visit({"/contacts/point", vectors, unit::mm, number(), "point on the reference's surface, world W"}, contacts.point_mm);
  visit({"/contacts/normal", vectors, unit::one, rule(Rule::unit_rows), "unit direction of the reaction on the moving object, world W"}, contacts.normal);
  visit({"/contacts/distance", contact, unit::mm, number(), "distance of the two surfaces"}, contacts.distance_mm);
  visit({"/contacts/triangle_reference", contact, unit::one, count(), "row of /bodies/reference/triangles of the motion model"}, contacts.triangle_reference);
  visit({"/contacts/triangle_moving", contact, unit::one, count(), "row of /bodies/moving/triangles of the motion model"}, contacts.triangle_moving);
  visit({"/contacts/compartment", contact, unit::none, codes(FlagSet::compartment), "compartment of the contact"}, contacts.compartment);
}

}  // namespace

// clang-format on
}  // namespace registry

void visit_registry(Trace& trace, RegistryVisitor& visit)
{
  using namespace registry;
  visit.attribute("/", "title", trace.title);
  visit.attribute("/", "side", trace.side);
  visit.attribute("/", "job_key", trace.job_key);
  visit.attribute("/", "approach_step_mm", trace.approach_step_mm);
  visit.attribute("/", "translation_resolution_mm", trace.translation_resolution_mm);
  visit.attribute("/", "rotation_resolution_deg", trace.rotation_resolution_deg);
  visit.dimension("/xyz", DimensionSize::fixed(3));
  visit_searches(trace, visit);
  visit_moves(trace, visit);
  visit_trace_contacts(trace.contacts, visit);
  visit.group("/job");
  visit.dimension("/job/input", DimensionSize::counted(trace.job.inputs.size()));
  visit({"/job/resolved", {}, unit::none, rule(Rule::any), "every key of the job with its value"},
        trace.job.resolved);
  visit_inputs(trace.job.inputs, visit);
}

}  // namespace vrda::store
