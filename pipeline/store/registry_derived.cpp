/// Rows of the registry: data derived from the raw surfaces (smoothed sets, zero-varus motion, audits).
#include "store/registry_rows.hpp"

namespace vrda::store::registry {

// One line per dataset.
// clang-format off

/// The optional fifth surface, of the varus found, is named `varus_solved` like the raw one: xarray cannot open a
/// `varus` over (flexion, varus).
void visit_smoothed(SmoothedSet& set, RowVisitor& visit)
{
  const std::string group = smoothed_group(set.degree);
  const std::vector<std::string> grid{"/flexion", "/varus"};
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
    const std::string path = smoothed_path(set.degree, surface.name);
    visit({path, grid, units, rule(Rule::any), "smoothed surface on the grid"}, surface.values);
    visit({coefficients_path(set.degree, surface.name), {group + "/term"}, units, number(), "coefficients of the terms"}, surface.coefficients);
    visit.attribute(path, "n_cells", surface.n_cells);
    visit.attribute(path, "rms", surface.rms, units);
    visit.attribute(path, "largest_residual", surface.largest_residual, units);
    visit.attribute(path, "leave_one_out_rms", surface.leave_one_out_rms, units);
    visit.attribute(path, "condition_number", surface.condition_number);
  }
  if (!has_optional(visit, group + "/recontact", set.recontact_mm)) return;
  visit({group + "/recontact", grid, unit::mm, number_or_nan(), "travel along Delta from the smoothed pose into contact"}, *set.recontact_mm);
}

void visit_two_sided(TwoSided& motion, RowVisitor& visit)
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
  visit({group + "/gap_medial", flexion, unit::mm, number(posed), "gap along Delta of the medial compartment"}, motion.gap_medial_mm);
  visit({group + "/gap_lateral", flexion, unit::mm, number(posed), "gap along Delta of the lateral compartment"}, motion.gap_lateral_mm);
}

void visit_repair(RepairedFrames& repair, RowVisitor& visit)
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

void visit_zero_varus_poses(ZeroVarus& motion, RowVisitor& visit)
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
  visit({group + "/flexion_angle", flexion, unit::degree, number(posed), "Grood-Suntay flexion"}, motion.clinical_flexion_deg);
  visit({group + "/varus_angle", flexion, unit::degree, number(posed), "Grood-Suntay varus, adduction positive"}, motion.clinical_varus_deg);
  visit({group + "/internal_rotation", flexion, unit::degree, number(posed), "Grood-Suntay internal rotation"}, motion.internal_rotation_deg);
  visit({group + "/anterior", flexion, unit::mm, number(posed), "translation of the rotation centre along the floating axis, anterior positive"}, motion.anterior_mm);
  visit({group + "/proximal", flexion, unit::mm, number(posed), "translation of the rotation centre along the moving body's long axis, proximal positive"}, motion.proximal_mm);
  visit({group + "/lateral", flexion, unit::mm, number(posed), "translation of the rotation centre along the flexion axis, lateral positive"}, motion.lateral_mm);
}

}  // namespace

void visit_zero_varus(ZeroVarus& motion, bool has_compartments, RowVisitor& visit)
{
  const std::string group = "/zero_varus";
  const std::vector<std::string> interval{group + "/interval"}, vectors{group + "/interval", "/xyz"};
  visit.group(group);
  visit.attribute(group, "set", motion.set);
  visit_zero_varus_poses(motion, visit);
  const std::int8_t none = code_of(ZeroVarusSource::none);
  const ValueCondition posed{ValueCondition::When::not_at_code, values_of(motion.source), none,
                       "where source is not none"};
  if (has_compartments) visit_paths(motion, group, {"/flexion", "/xyz"}, posed, visit);
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
  visit({group + "/medial_rolling", interval, unit::mm, between, "rolling in the medial compartment"}, motion.medial_rolling_mm);
  visit({group + "/medial_sliding", interval, unit::mm, between, "sliding in the medial compartment"}, motion.medial_sliding_mm);
  visit({group + "/lateral_rolling", interval, unit::mm, between, "rolling in the lateral compartment"}, motion.lateral_rolling_mm);
  visit({group + "/lateral_sliding", interval, unit::mm, between, "sliding in the lateral compartment"}, motion.lateral_sliding_mm);
}

void visit_audit(AuditSet& audit, const AuditedModel& model, RowVisitor& visit)
{
  using When = ValueCondition::When;
  const std::string group = audit_group(audit.name), flexion = group + "/flexion", varus = group + "/varus";
  const std::vector<std::string> grid{flexion, varus};
  const ValueCondition free{When::at_code, values_of(audit.state), code_of(AuditState::free),
                      "where state is free"};
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
  visit({group + "/state", grid, unit::none, codes(FlagSet::audit_state), "result of the audit"}, audit.state);
  visit({group + "/gap", grid, unit::mm, at_least_0(free), "travel along Delta to the next contact"}, audit.gap_mm);
  visit({group + "/penetration", grid, unit::mm, at_least_0(posed), "travel opposite to Delta to the first contact of an approach from far away"}, audit.penetration_mm);
  if (!model.has_compartments) return;
  visit({group + "/gap_medial", grid, unit::mm, number_or_nan(posed), "travel along Delta to the first contact of the medial compartment, negative: overlap"}, audit.gap_medial_mm);
  visit({group + "/gap_lateral", grid, unit::mm, number_or_nan(posed), "travel along Delta to the first contact of the lateral compartment, negative: overlap"}, audit.gap_lateral_mm);
}

// clang-format on
}  // namespace vrda::store::registry
