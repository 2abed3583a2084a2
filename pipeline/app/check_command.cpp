// `vrda check`: reads a job with its meshes, measures start pose, sizes and overlaps; prints findings and
// warnings.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/case_picture.hpp"
#include "job/case_warnings.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

// A number or a list; a setting over flexion becomes a table with one row per angle, as in the job.
Json over_flexion_json(const job::FlexionTable& setting)
{
  if (!setting.columns.empty()) return {{"columns", setting.columns}};
  Json rows = Json::array(), angles_deg = Json::array();
  for (Eigen::Index i = 0; i < setting.value.rows(); ++i) {
    const Eigen::VectorXd row = setting.value.row(i).transpose();
    rows.push_back(row.size() == 1 ? Json(row[0]) : Json(std::vector<double>(row.begin(), row.end())));
  }
  if (rows.size() == 1) return rows[0];
  for (const double flexion_rad : setting.flexion_rad) angles_deg.push_back(deg_from_rad(flexion_rad));
  return {{"flexion_deg", angles_deg}, {"value", rows}};
}

Json loads_json(const job::PushJob& push, const job::Case& job_case)
{
  Json loads = Json::array();
  for (std::size_t k = 0; k < push.loads.size(); ++k) {
    const job::LoadPoint& at = job_case.loads.at(k);
    loads.push_back({{"name", at.name},
                     {"frame", name_of(at.frame)},
                     {"force_n", over_flexion_json(push.loads[k].force_n)},
                     {"moment_nmm", over_flexion_json(push.loads[k].moment_nmm)},
                     {"point_mm", json_value(at.point_mm)}});
  }
  return loads;
}

Json lines_json(const job::PushJob& push, const job::Case& job_case)
{
  Json lines = Json::array();
  for (std::size_t k = 0; k < push.lines.size(); ++k) {
    const job::LinePath& path = job_case.lines.at(k);
    lines.push_back({{"name", path.name},
                     {"tension_n", over_flexion_json(push.lines[k].tension_n)},
                     {"reference_mm", json_value(path.reference_mm)},
                     {"moving_mm", json_value(path.moving_mm)}});
  }
  return lines;
}

Json push_json(const job::PushJob& push, const job::Case& job_case)
{
  return {{"delta", over_flexion_json(push.delta)},
          {"force_n", over_flexion_json(push.force_n)},
          {"lateral_force_n", over_flexion_json(push.lateral_force_n)},
          {"moment_nmm", over_flexion_json(push.moment_nmm)},
          {"varus_moment_nmm", over_flexion_json(push.varus_moment_nmm)},
          {"point_mm", json_value(job_case.push_point_mm)},
          {"loads", loads_json(push, job_case)},
          {"lines", lines_json(push, job_case)}};
}

std::string number_text(const Json& number_or_list)
{
  if (!number_or_list.is_array()) return shortest_decimal(number_or_list.get<double>());
  std::string text;
  for (const Json& number : number_or_list)
    text += (text.empty() ? "[" : " ") + shortest_decimal(number.get<double>());
  return text + "]";
}

// "20 N", or the first and last row of a table over flexion.
void print_load(const char* name, const Json& load, const char* unit)
{
  std::string text;
  if (!load.is_object()) {
    text = number_text(load) + unit;
  } else if (load.contains("columns")) {
    text = "from columns of the frames";
    for (const Json& column : load["columns"]) text += " " + column.get<std::string>();
  } else {
    const Json& angles_deg = load["flexion_deg"];
    const Json& rows = load["value"];
    text = number_text(rows.front()) + unit + " at " + shortest_decimal(angles_deg.front().get<double>()) +
           " degrees of flexion to " + number_text(rows.back()) + unit + " at " +
           shortest_decimal(angles_deg.back().get<double>()) + ", in " + std::to_string(rows.size()) +
           " rows";
  }
  std::printf("  %-18s %s\n", name, text.c_str());
}

void print_push(const Json& p, bool has_forces)
{
  std::printf("push\n");
  print_load("delta", p["delta"], "");
  if (!has_forces) return;  // the search moves along Delta without a force
  print_load("force", p["force_n"], " N along delta");
  print_load("lateral force", p["lateral_force_n"], " N across delta");
  print_load("moment", p["moment_nmm"], " N mm about delta");
  print_load("varus moment", p["varus_moment_nmm"], " N mm");
  print_load("point", p["point_mm"], " mm from the rotation centre");
  for (const Json& load : p["loads"]) {
    print_filled("  load {name}, frame {frame}\n", load);
    print_load("  force", load["force_n"], " N");
    print_load("  moment", load["moment_nmm"], " N mm");
    print_load("  point", load["point_mm"], " mm from the rotation centre");
  }
  for (const Json& line : p["lines"]) {
    print_filled("  line {name}\n", line);
    print_load("  tension", line["tension_n"], " N");
    print_load("  from", line["reference_mm"].back(), " mm on the reference");
    print_load("  to", line["moving_mm"].front(), " mm on the moving object");
  }
}

// Overlap and travel to contact at the initial pose of the job.
Json initial_pose_of(const run::InitialContact& start, const job::Case& job_case)
{
  return {{"overlapping", start.is_overlapping},
          {"travel_along_delta_mm", std::isfinite(start.travel_mm) ? Json(start.travel_mm) : Json()},
          {"substep_mm", start.substep_mm},
          {"approach_step_mm", job_case.search.approach_step_mm}};
}

Json component_json(const job::ComponentSurvey& c)
{
  return {{"body", c.body},
          {"name", c.name},
          {"source", c.source},
          {"contact", c.has_contact},
          {"triangles", c.n_triangles},
          {"vertices", c.n_vertices},
          {"closed", c.n_boundary_edges == 0},
          {"boundary_edges", c.n_boundary_edges},
          {"open_sheet", c.has_sheet},
          {"non_manifold_edges", c.n_non_manifold_edges},
          {"vertices_welded", c.n_welded},
          {"degenerate_faces_dropped", c.n_degenerate},
          {"degenerate_places", c.degenerate_places},
          {"identical_triangles_dropped", c.n_identical},
          {"turned_outward", c.was_flipped},
          {"box_min_mm", json_value(c.box.min_mm)},
          {"box_max_mm", json_value(c.box.max_mm)},
          {"mean_edge_mm", c.mean_edge_mm},
          {"volume_mm3", c.n_boundary_edges == 0 ? Json(c.volume_mm3) : Json()}};
}

// The values found for "auto" in the job.
Json found_frames_json(const std::optional<job::FoundFrames>& found)
{
  if (!found) return {};
  const auto frame = [](const job::FoundFrame& f) {
    return Json{{"origin", json_value(f.origin_native)}, {"rotation_deg", json_value(f.rotation_deg)}};
  };
  return {{"reference", frame(found->reference)}, {"moving", frame(found->moving)}};
}

Json axis_json(const std::vector<double>& values)
{
  return {{"from_deg", values.front()}, {"to_deg", values.back()}, {"count", values.size()}};
}

Json grid_json(const job::Case& job_case, const solve::SweepPlan& plan)
{
  return {{"flexion", axis_json(job_case.grid.flexion_deg)},
          {"varus", job_case.is_varus_free ? Json() : axis_json(job_case.grid.varus_deg)},
          {"varus_is_free", job_case.is_varus_free},
          {"attitudes", plan.flexion_rad.size() * plan.varus_rad.size()}};
}

// Roles of the coordinates where a grid cannot express them, and the frames of a sequence.
Json coordinates_json(const job::Case& job_case)
{
  if (!job_case.coordinates) return {};
  Json roles;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    roles[joint_coordinate_names[k]] = name_of(job_case.coordinates->role[k]);
  Json out{{"roles", roles}};
  if (!job_case.coordinates->is_sequence()) return out;
  const std::vector<double>& key = job_case.coordinates->key;
  out["frames"] = {{"key", job_case.coordinates->key_name},
                   {"from", key.front()},
                   {"to", key.back()},
                   {"count", key.size()}};
  return out;
}

bool is_search(const job::Case& job_case)
{
  return job_case.method == "stability-search";
}

Json steps_json(const job::Case& job_case)
{
  if (!is_search(job_case)) return {};
  const SearchOptions& s = job_case.search;
  return {{"translation_mm", s.translation_step_mm},
          {"translation_resolution_mm", s.translation_resolution_mm},
          {"rotation_deg", deg_from_rad(s.rotation_step_rad)},
          {"rotation_resolution_deg", deg_from_rad(s.rotation_resolution_rad)}};
}

Json equilibrium_json(const job::Case& job_case)
{
  if (is_search(job_case)) return {};
  Json json = {{"tolerance_mm", job_case.equilibrium.tolerance_mm},
               {"max_iterations", job_case.equilibrium.max_iterations},
               {"contact_resolution_mm", job_case.equilibrium.contact_resolution_mm},
               {"restarts", job_case.spine.n_restarts},
               {"band_moment_nmm", job_case.spine.band_moment_nmm}};
  if (job_case.spine.branch == BranchRule::continuous) json["branch"] = "continuous";
  return json;
}

// Bundles in the order of their first fibres.
Json ligaments_json(const model::Ligaments& ligaments)
{
  if (ligaments.fibres.empty()) return {};
  Json bundles = Json::array(), wraps = Json::array();
  for (const model::Wrap& wrap : ligaments.wraps) {
    wraps.push_back({{"name", wrap.name},
                     {"shape", wrap.shape == model::WrapShape::cylinder ? "cylinder" : "ellipsoid"},
                     {"body", name_of(wrap.body)},
                     {"fibres", 0}});
  }
  for (const model::Fibre& fibre : ligaments.fibres) {
    auto bundle = std::find_if(bundles.begin(), bundles.end(),
                               [&](const Json& b) { return b["name"] == fibre.bundle; });
    if (bundle == bundles.end())
      bundle = bundles.insert(bundles.end(), Json{{"name", fibre.bundle}, {"fibres", 0}});
    (*bundle)["fibres"] = (*bundle)["fibres"].get<int>() + 1;
    if (fibre.wrap < 0) continue;
    Json& n_wrapped = wraps[static_cast<std::size_t>(fibre.wrap)]["fibres"];
    n_wrapped = n_wrapped.get<int>() + 1;
  }
  return {{"fibres", ligaments.fibres.size()},
          {"bundles", bundles},
          {"wraps", wraps},
          {"transition_strain", ligaments.transition_strain}};
}

Json job_json(const job::Case& job_case, const run::InitialContact& start, const job::PushJob& push)
{
  const solve::SweepPlan plan = solve::plan_of(job_case);
  Json components = Json::array();
  for (const job::ComponentSurvey& c : job_case.survey) components.push_back(component_json(c));
  return {{"title", job_case.title},
          {"joint", job_case.joint},
          {"side", side_name(job_case.frame.side)},
          {"method", job_case.method},
          {"solver_version", solve::solver_version_of(job_case)},
          {"job_key", solve::fingerprint_of(job_case)},
          {"rotation_centre_mm", json_value(job_case.frame.rotation_centre_mm)},
          {"found_frames", found_frames_json(job_case.found_frames)},
          {"delta", json_value(job_case.frame.delta)},
          {"scaling", run::scaling_json(job_case.scaling)},
          {"scaling_note", run::scaling_line(job_case)},
          {"components", components},
          {"initial_pose", initial_pose_of(start, job_case)},
          {"ligaments", ligaments_json(job_case.ligaments)},
          {"push", push_json(push, job_case)},
          {"grid", grid_json(job_case, plan)},
          {"coordinates", coordinates_json(job_case)},
          {"steps", steps_json(job_case)},
          {"equilibrium", equilibrium_json(job_case)},
          {"smooth_degrees", job_case.smooth_degrees},
          {"smooth_recontact", job_case.smooth_recontact},
          {"smooth_robust", job_case.smooth_robust},
          {"warnings", job_case.warnings}};
}

void print_component(const Json& c)
{
  print_filled("  {body%-10s} {name%-18s} {triangles%7d} triangles, ", c);
  print_filled(c["closed"] ? "closed" : "open", c);
  print_filled(", mean edge {mean_edge_mm%.2f} mm", c);
  std::printf(c["contact"] ? "\n" : ", drawn only\n");
  print_filled(
      "             box [{box_min_mm.0%.1f} {box_min_mm.1%.1f} {box_min_mm.2%.1f}] to "
      "[{box_max_mm.0%.1f} {box_max_mm.1%.1f} {box_max_mm.2%.1f}] mm",
      c);
  if (c["boundary_edges"] > 0) print_filled(", {boundary_edges} boundary edges", c);
  if (c["open_sheet"])
    std::printf(
        ", an open sheet: the winding of its triangles defines its outside (winding = \"inward\" reverses "
        "it)");
  if (c["degenerate_faces_dropped"] > 0)
    print_filled(", {degenerate_faces_dropped} degenerate faces dropped, {degenerate_places}", c);
  if (c["identical_triangles_dropped"] > 0)
    print_filled(", {identical_triangles_dropped} identical triangles dropped", c);
  std::printf(c["turned_outward"] ? ", turned outward\n" : "\n");
}

void print_coordinates(const Json& coordinates)
{
  if (coordinates.is_null()) return;
  if (coordinates.contains("frames"))
    print_filled("  {count} frames, {key} {from%g} to {to%g}\n", coordinates["frames"]);
  for (const auto& [name, role] : coordinates["roles"].items())
    std::printf("  %-9s  %s\n", name.c_str(), role.get<std::string>().c_str());
}

void print_axis(const char* name, const Json& axis)
{
  std::printf("  %-8s ", name);
  print_filled(axis.is_null() ? "free\n" : "{from_deg%g} to {to_deg%g} degrees, {count} values\n", axis);
}

void print_ligaments(const Json& l)
{
  if (l.is_null()) {
    std::printf("ligaments: none\n");
    return;
  }
  print_filled("ligaments: {fibres} fibres in ", l);
  std::printf("%zu bundles, %zu wraps\n", l["bundles"].size(), l["wraps"].size());
  for (const Json& bundle : l["bundles"]) print_filled("  {name%-18s} {fibres} fibres\n", bundle);
  for (const Json& wrap : l["wraps"])
    print_filled("  {name%-18s} {shape} on the {body} object, for {fibres} fibres\n", wrap);
  if (!l.contains("in_bone")) return;
  for (const Json& line : l["in_bone"]) std::printf("  %s\n", line.get<std::string>().c_str());
}

void print_method(const Json& u)
{
  if (!u["steps"].is_null()) {
    print_filled(
        "  translation {translation_mm%g} mm to {translation_resolution_mm%g} mm, rotation {rotation_deg%g} "
        "to "
        "{rotation_resolution_deg%g} degrees\n",
        u["steps"]);
    return;
  }
  print_filled(
      "  tolerance {tolerance_mm%g} mm in at most {max_iterations} iterations, contact resolution "
      "{contact_resolution_mm%g} mm\n"
      "  along the spine {restarts} restarts per flexion, rotation band for {band_moment_nmm%g} N mm\n",
      u["equilibrium"]);
  if (u["equilibrium"].contains("branch"))
    std::puts("  of several equilibria those of the continuous path over flexion");
}

void print(const Json& u)
{
  print_filled(
      "{title}: {joint}, {side} side, {method}\n"
      "rotation centre [{rotation_centre_mm.0%.2f} {rotation_centre_mm.1%.2f} {rotation_centre_mm.2%.2f}] "
      "mm, "
      "canonical axes\n",
      u);
  for (const char* body : {"reference", "moving"}) {
    if (u["found_frames"].is_null()) break;
    const Json& frame = u["found_frames"][body];
    std::printf("%s.frame found: origin %s, align rotation %s degrees\n", body,
                number_text(frame["origin"]).c_str(), number_text(frame["rotation_deg"]).c_str());
  }
  run::print_scaling(u["scaling"]);
  if (u["scaling_note"] != "") print_filled("  {scaling_note}\n", u);
  std::printf("components\n");
  for (const Json& c : u["components"]) print_component(c);
  const Json& start = u["initial_pose"];
  if (start["overlapping"].get<bool>()) {
    std::printf("initial pose: the objects overlap by %.3f mm along Delta; the first step retreats\n",
                -start.value("travel_along_delta_mm", 0.0));
  } else if (start["travel_along_delta_mm"].is_null()) {
    std::printf("initial pose: the reference is not along Delta\n");
  } else {
    print_filled("initial pose: {travel_along_delta_mm%.3f} mm along Delta to the first contact\n", start);
  }
  print_ligaments(u["ligaments"]);
  print_push(u["push"], !u["equilibrium"].is_null());
  print_filled("plan: {grid.attitudes} attitudes\n", u);
  print_coordinates(u["coordinates"]);
  if (!u["coordinates"].contains("frames")) {
    print_axis("flexion", u["grid"]["flexion"]);
    print_axis("varus", u["grid"]["varus"]);
  }
  print_method(u);
  for (const Json& w : u["warnings"]) std::printf("warning: %s\n", w.get<std::string>().c_str());
}

void write_picture(const std::string& path, const job::Case& job_case, const job::Job& job,
                   std::size_t n_warnings)
{
  job::PictureNotes notes;
  notes.n_warnings = n_warnings;
  // Objects with frames of their own have no common axes of files.
  if (job::has_mesh_file(job) && !job.reference.frame && !job.moving.frame)
    notes.file_axes = {job.frame.anterior, job.frame.proximal, job.frame.right};
  run::publish(path, "vrda check", job::case_picture(job_case, notes));
}

}  // namespace

nlohmann::ordered_json check_json(const CheckOptions& options)
{
  const job::Job job = job::read_job(options.job_file, options.overrides);
  const run::CheckedCase checked = run::load_checked_case(job, options.data_directory);
  const job::Case job_case = job::scaled_to_subject(checked.job_case);
  Json result = job_json(job_case, checked.initial, job.push);
  const std::vector<std::string> in_bone = job::bone_crossing_warnings(job_case);
  if (!in_bone.empty()) result["ligaments"]["in_bone"] = in_bone;
  if (!options.picture.empty()) write_picture(options.picture, job_case, job, job_case.warnings.size());
  return result;
}

core::ExitCode check_command(const CheckOptions& options)
{
  const Json result = check_json(options);
  if (options.as_json) return print_json(result);
  print(result);
  return core::ExitCode::done;
}

void declare_check(Command& c)
{
  auto& o = c.options<CheckOptions>();
  c.job(o.job_file);
  c.loading(o);
  c.option("--picture", o.picture,
           "PNG file to draw: bones, axes, rotation centre, push and fibres in two views");
  c.json(o.as_json);
  c.runs([&o] { return check_command(o); });
}

}  // namespace vrda::app
