#include "report/model_json.hpp"

#include <algorithm>

#include "model/joint_kind.hpp"
#include "store/poses.hpp"
#include "report/report.hpp"
#include "store/motion_model_file.hpp"

namespace vrda::report {
namespace {

bool is_varus_free(const store::MotionModel& model)
{
  return store::Motion(model, "raw").is_varus_free();
}

Json body_json(const Body& body)
{
  Json components = Json::array();
  for (const Component& c : body.components)
    components.push_back({{"name", c.name}, {"material", c.material}});
  return {{"name", body.name},
          {"components", components},
          {"contact_triangles", body.contact.mesh.triangles.rows()},
          {"visual_triangles", body.visual.mesh.triangles.rows()}};
}

Json statuses_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const StepStatus status : all_step_statuses) {
    const auto code = static_cast<std::int8_t>(status);
    const auto n = (model.status == code).count();
    list.push_back(
        {{"code", code}, {"name", name_of(status)}, {"meaning", meaning_of(status)}, {"cells", n}});
  }
  return list;
}

Json plausibilities_json()
{
  Json list = Json::array();
  for (const Plausibility plausibility : all_plausibilities) {
    list.push_back({{"code", static_cast<std::int8_t>(plausibility)}, {"name", name_of(plausibility)}});
  }
  return list;
}

Json rotation_json(const store::CurveFigures& f)
{
  return {{"net_deg", short_number(f.net_deg)},
          {"first_deg", short_number(f.first_deg)},
          {"last_deg", short_number(f.last_deg)},
          {"peak_deg", short_number(f.peak_deg)},
          {"peak_at_deg", short_number(f.peak_at_deg)},
          {"change_deg", short_number(f.change_deg)},
          {"change_from_deg", short_number(f.change_from_deg)},
          {"change_to_deg", short_number(f.change_to_deg)}};
}

Json numbers_json(const ReportModel& entry)
{
  const MotionSummary n = motion_summary(entry.model);
  return {{"cells", n.n_cells},
          {"stable", n.n_stable},
          {"overlapping", entry.raw.n_overlapping},
          {"largest_penetration_mm", short_number(entry.raw.largest_penetration_mm)},
          {"largest_gap_mm", short_number(entry.raw.largest_gap_mm)},
          {"contact_resolution_mm", short_number(entry.model.contact_resolution_mm)},
          {"theta_undetermined_share", short_number(n.theta_undetermined_share)},
          {"rotation", rotation_json(n.rotation)},
          {"largest_spine_jump_deg", short_number(n.spine_jump.change_deg)},
          {"several_optima", n.n_several_optima},
          {"optima_spread_deg", short_number(n.largest_optima_spread_deg)},
          {"balance_residual_n", short_number(n.balance_residual_n)},
          {"worst_gap_mm", short_number(n.worst_gap_mm)},
          {"push_n", short_number(n.push_n)},
          {"fibres", entry.model.ligaments ? entry.model.ligaments->name.size() : 0},
          {"largest_strain", short_number(n.largest_strain)},
          {"largest_tension_n", short_number(n.largest_tension_n)}};
}

// What the kind calls the rotations; nothing where it uses their keys.
Json words_json(const JointKind& kind)
{
  if (!has_own_words(kind)) return {};
  return {{"flexion", label_of(kind, JointCoordinate::flexion)},
          {"varus", label_of(kind, JointCoordinate::varus)}};
}

Json head_json(const ReportModel& entry)
{
  const store::MotionModel& model = entry.model;
  Json head = {{"name", entry.name},
               {"title", model.title},
               {"joint", model.joint},
               {"side", model.side},
               {"method", model.method},
               {"is_varus_free", is_varus_free(model)},
               {"has_compartments", model.has_compartments},
               {"reference", body_json(model.reference)},
               {"moving", body_json(model.moving)},
               {"key_name", model.frames ? Json(model.frames->key_name) : Json()},
               {"flexion", short_numbers(model.frames ? model.frames->key : model.flexion_deg)},
               {"varus", short_numbers(model.varus_deg)},
               {"statuses", statuses_json(model)},
               {"numbers", numbers_json(entry)},
               {"default_motion", store::default_motion(model).set},
               {"warnings", warnings_of(entry)}};
  if (const Json words = words_json(joint_kind(model.joint)); !words.is_null()) head["words"] = words;
  return head;
}

Json curves_json(const store::MotionModel& model, const Eigen::Vector3d& point_mm)
{
  Json list = Json::array();
  for (const ClinicalCurve& curve : clinical_curves(model, point_mm)) list.push_back(curve_json(curve));
  return list;
}

Json raw_surfaces_json(const store::MotionModel& model)
{
  Json raw = {{"name", "raw"},
              {"tx", short_grid(model.tx_mm)},
              {"ty", short_grid(model.ty_mm)},
              {"tz", short_grid(model.tz_mm)},
              {"theta", short_grid(model.theta_deg)}};
  if (is_varus_free(model)) raw["varus"] = short_grid(model.varus_solved_deg);
  if (model.frames) {
    const auto n = static_cast<Eigen::Index>(model.flexion_deg.size());
    raw["frame_flexion"] = short_grid(Eigen::Map<const store::GridD>(model.flexion_deg.data(), n, 1));
  }
  return raw;
}

// The set's surfaces plus the travel into contact, in W along the Delta of each flexion.
Json recontacted_json(const store::MotionModel& model, const store::SmoothedSet& set, const std::string& name)
{
  Json result = {{"name", name}};
  for (const store::SmoothedSurface& surface : set.surfaces) {
    store::GridD values = surface.values;
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      const Eigen::Vector3d delta = model.push.delta.row(i).transpose();
      const double component = surface.name == "tx"   ? delta.x()
                               : surface.name == "ty" ? delta.y()
                               : surface.name == "tz" ? delta.z()
                                                      : 0.0;
      if (component != 0.0) values.row(i) += component * set.recontact_mm->row(i);
    }
    result[surface.name] = short_grid(values);
  }
  return result;
}

Json surfaces_json(const store::MotionModel& model)
{
  Json list = Json::array({raw_surfaces_json(model)});
  for (const store::SmoothedSet& set : model.smoothed) {
    const std::string name = "degree_" + std::to_string(set.degree);
    Json values = {{"name", name}};
    for (const store::SmoothedSurface& surface : set.surfaces)
      values[surface.name] = short_grid(surface.values);
    list.push_back(std::move(values));
    if (set.recontact_mm) list.push_back(recontacted_json(model, set, name + "_recontacted"));
  }
  return list;
}

Json degrees_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const store::SmoothedSet& set : model.smoothed) {
    Json surfaces = Json::array();
    for (const store::SmoothedSurface& s : set.surfaces) {
      surfaces.push_back({{"name", s.name},
                          {"cells", s.n_cells},
                          {"rms", short_number(s.rms)},
                          {"largest_residual", short_number(s.largest_residual)},
                          {"leave_one_out_rms", short_number(s.leave_one_out_rms)},
                          {"condition_number", short_number(s.condition_number)}});
    }
    list.push_back({{"degree", set.degree},
                    {"is_robust", set.is_robust},
                    {"is_recontacted", set.recontact_mm.has_value()},
                    {"surfaces", surfaces}});
  }
  return list;
}

double largest_of(const store::GridD& grid)
{
  double most = -1.0;
  for (Eigen::Index k = 0; k < grid.size(); ++k) {
    if (grid.data()[k] > most) most = grid.data()[k];
  }
  return most;
}

Json two_sided_json(const store::TwoSidedFigures& f)
{
  if (f.n_poses == 0) return nullptr;
  return {{"poses", f.n_poses},
          {"both_in_contact", f.n_both_in_contact},
          {"largest_gap_medial_mm", short_number(f.largest_gap_medial_mm)},
          {"largest_overlap_medial_mm", short_number(f.largest_overlap_medial_mm)},
          {"largest_gap_lateral_mm", short_number(f.largest_gap_lateral_mm)},
          {"largest_overlap_lateral_mm", short_number(f.largest_overlap_lateral_mm)}};
}

Json audits_json(const store::MotionModel& model)
{
  Json list = Json::array();
  for (const store::AuditSet& a : model.audits) {
    const auto n_of = [&](store::AuditState state) {
      return (a.state == static_cast<std::int8_t>(state)).count();
    };
    const double gap_mm = largest_of(a.gap_mm), penetration_mm = largest_of(a.penetration_mm);
    list.push_back({{"name", a.name},
                    {"refine", a.refine},
                    {"attitudes", a.state.size()},
                    {"no_pose", n_of(store::AuditState::no_pose)},
                    {"overlapping", n_of(store::AuditState::overlapping)},
                    {"nothing_ahead", n_of(store::AuditState::nothing_ahead)},
                    {"largest_gap_mm", gap_mm < 0.0 ? Json() : short_number(gap_mm)},
                    {"largest_penetration_mm", penetration_mm < 0.0 ? Json() : short_number(penetration_mm)},
                    {"two_sided", two_sided_json(store::two_sided_figures(a))}});
  }
  return list;
}

Json scaling_json(const std::optional<Scaling>& scaling)
{
  if (!scaling) return {};
  return {{"factor", short_numbers({scaling->factor.x(), scaling->factor.y(), scaling->factor.z()})},
          {"keeps_steps", scaling->keeps_steps},
          {"standard_error", short_number(scaling->standard_error)},
          {"residual_rms_mm", short_number(scaling->residual_rms_mm)},
          {"landmarks", scaling->landmark},
          {"model_mm", short_numbers(scaling->model_mm)},
          {"subject_mm", short_numbers(scaling->subject_mm)},
          {"residual_mm", short_numbers(scaling->residual_mm)}};
}

Json provenance_json(const store::MotionModel& model)
{
  Json inputs = Json::array();
  for (const store::InputFile& input : model.job.inputs)
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}});
  return {{"job", model.job.text},
          {"resolved", model.job.resolved},
          {"inputs", inputs},
          {"scaling", scaling_json(model.job.scaling)},
          {"format_version", store::format_version}};
}

Json flags_json(const store::GridB& flags)
{
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < flags.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < flags.cols(); ++j) row.push_back(static_cast<int>(flags(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

// Bit 0: contact of the medial compartment, bit 1: of the lateral one; -1 without a pose.
Json contacts_json(const store::MotionModel& model)
{
  if (!model.has_compartments) return nullptr;
  store::GridB contacts = model.contact_medial;
  for (Eigen::Index k = 0; k < contacts.size(); ++k) {
    if (contacts.data()[k] < 0) continue;
    contacts.data()[k] =
        static_cast<std::int8_t>(model.contact_medial.data()[k] + 2 * model.contact_lateral.data()[k]);
  }
  return flags_json(contacts);
}

Json errors_json(const std::string& name, const analysis::ErrorMeasures& errors)
{
  return {{"name", name},
          {"rms", short_number(errors.rms)},
          {"largest", short_number(errors.largest)},
          {"leave_one_out", short_number(errors.leave_one_out)},
          {"roughness", short_number(errors.roughness)}};
}

Json faults_json(const analysis::DegreeRow& row)
{
  if (!row.audit_totals) return nullptr;
  const analysis::AuditTotals& f = row.audit_totals->at_grid;
  return {{"attitudes", f.n_attitudes},
          {"overlapping", f.n_overlapping},
          {"nothing_ahead", f.n_nothing_ahead},
          {"largest_penetration_mm", short_number(f.largest_penetration_mm)},
          {"largest_gap_mm", short_number(f.largest_gap_mm)}};
}

Json contact_json(const std::optional<analysis::ContactFigures>& contact)
{
  if (!contact) return nullptr;
  return {{"poses", contact->n_poses},
          {"lifted_off", contact->n_lifted_off},
          {"largest_gap_mm", short_number(contact->largest_gap_mm)},
          {"largest_overlap_mm", short_number(contact->largest_overlap_mm)},
          {"two_sided", contact->sides ? two_sided_json(*contact->sides) : Json()}};
}

Json comparison_json(const std::optional<analysis::Comparison>& comparison)
{
  if (!comparison) return nullptr;
  Json rows = Json::array();
  const analysis::Recommendation& r = comparison->recommendation;
  for (std::size_t k = 0; k < comparison->rows.size(); ++k) {
    const analysis::DegreeRow& row = comparison->rows[k];
    Json errors = Json::array({errors_json("translation", row.translation)});
    for (const analysis::SurfaceRow& surface : row.surfaces) {
      const bool is_angle = surface.name == "theta" || surface.name == "varus";
      if (is_angle) errors.push_back(errors_json(surface.name, surface.errors));
    }
    rows.push_back({{"degree", row.set.degree},
                    {"errors", errors},
                    {"perceptible_share", short_number(row.perceptible_share)},
                    {"left_out", short_number(r.ranked[k].error)},
                    {"second_difference", short_number(row.second_difference)},
                    {"contact", contact_json(row.contact)},
                    {"fault", name_of(r.ranked[k].fault)},
                    {"faults", faults_json(row)}});
  }
  return {{"rows", rows},
          {"not_carried", comparison->undetermined_degrees},
          {"recommended", r.degree},
          {"status", r.degree >= 0 ? "recommended" : name_of(r.fault)},
          {"left_out", {{"flexions", r.block_size.flexion}, {"varus_columns", r.block_size.varus}}},
          {"reason", r.reason}};
}

std::string base64(const std::string& bytes)
{
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - k);
    unsigned word = 0;
    for (std::size_t j = 0; j < 3; ++j)
      word = word << 8 | (j < n ? static_cast<unsigned char>(bytes[k + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= n ? digits[word >> (18 - 6 * j) & 63u] : '=';
  }
  return text;
}

Json stills_json(const RenderedImages& stills)
{
  Json list = Json::array();
  for (const RenderedImage& still : stills.images)
    list.push_back({{"view", still.view}, {"label", still.label}, {"png", base64(still.png)}});
  return {{"note", stills.note}, {"stills", list}};
}

}  // namespace

Json curve_json(const ClinicalCurve& curve)
{
  Json values = {{"name", curve.name}, {"flexion", short_numbers(curve.flexion_deg)}};
  for (const QuantityName& q : quantity_names) {
    if (!curve.values_of(q.quantity).empty()) values[q.key] = short_numbers(curve.values_of(q.quantity));
  }
  return values;
}

Json model_json(const ReportModel& entry, const ModelJsonOptions& options)
{
  const store::MotionModel& model = entry.model;
  Json json = head_json(entry);
  if (store::has_turned_axes(model)) json["axes_are_turned"] = true;
  json["point_mm"] = short_numbers({options.point_mm.begin(), options.point_mm.end()});
  json["curves"] = curves_json(model, options.point_mm);
  json["provenance"] = provenance_json(model);
  json["spine"] = spine_json(model);
  if (!options.is_whole) return json;
  json["status_grid"] = flags_json(model.status);
  json["plausibility_grid"] = flags_json(model.plausibility);
  json["plausibilities"] = plausibilities_json();
  json["contact_grid"] = contacts_json(model);
  json["theta_determined_grid"] = flags_json(model.theta_determined);
  json["surfaces"] = surfaces_json(model);
  json["degrees"] = degrees_json(model);
  json["comparison"] = comparison_json(entry.comparison);
  json["audits"] = audits_json(model);
  json["coordinates"] = coordinates_json(model);
  json["repair"] = repair_json(model);
  json["uncertainty"] = uncertainty_json(model);
  json["contact_paths"] = contact_paths_json(model);
  json["axes"] = axes_json(model);
  json["forces"] = forces_json(model);
  json["fibres"] = fibres_json(model);
  json["stills"] = stills_json(entry.images);
  return json;
}

}  // namespace vrda::report
