// `vrda check`: reads a job with its meshes, measures start pose, sizes and overlaps; prints findings and
// warnings.
#include "app/file_commands.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/check_push.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/case_picture.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> numbers(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
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
          {"identical_triangles_dropped", c.n_identical},
          {"turned_outward", c.was_flipped},
          {"box_min_mm", numbers(c.box.min_mm)},
          {"box_max_mm", numbers(c.box.max_mm)},
          {"mean_edge_mm", c.mean_edge_mm},
          {"volume_mm3", c.n_boundary_edges == 0 ? Json(c.volume_mm3) : Json()}};
}

// The values found for "auto" in the job.
Json found_frames_json(const std::optional<job::FoundFrames>& found)
{
  if (!found) return {};
  const auto frame = [](const job::FoundFrame& f) {
    return Json{{"origin", numbers(f.origin_native)}, {"rotation_deg", numbers(f.rotation_deg)}};
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
  return {{"tolerance_mm", job_case.equilibrium.tolerance_mm},
          {"max_iterations", job_case.equilibrium.max_iterations},
          {"contact_resolution_mm", job_case.equilibrium.contact_resolution_mm},
          {"restarts", job_case.spine.n_restarts},
          {"band_moment_nmm", job_case.spine.band_moment_nmm}};
}

// Bundles in the order of their first fibres.
Json ligaments_json(const model::Ligaments& ligaments)
{
  if (ligaments.fibres.empty()) return {};
  Json bundles = Json::array(), wraps = Json::array();
  for (const model::Wrap& wrap : ligaments.wraps) {
    wraps.push_back({{"name", wrap.name},
                     {"shape", wrap.shape == model::WrapShape::cylinder ? "cylinder" : "ellipsoid"},
                     {"body", wrap.body == model::WrapBody::reference ? "reference" : "moving"},
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
          {"rotation_centre_mm", numbers(job_case.frame.rotation_centre_mm)},
          {"found_frames", found_frames_json(job_case.found_frames)},
          {"delta", numbers(job_case.frame.delta)},
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
  std::printf("  %-10s %-18s %7ld triangles, %s, mean edge %.2f mm%s\n", c["body"].get<std::string>().c_str(),
              c["name"].get<std::string>().c_str(), c["triangles"].get<long>(),
              c["closed"].get<bool>() ? "closed" : "open", c["mean_edge_mm"].get<double>(),
              c["contact"].get<bool>() ? "" : ", drawn only");
  std::printf("             box [%.1f %.1f %.1f] to [%.1f %.1f %.1f] mm", c["box_min_mm"][0].get<double>(),
              c["box_min_mm"][1].get<double>(), c["box_min_mm"][2].get<double>(),
              c["box_max_mm"][0].get<double>(), c["box_max_mm"][1].get<double>(),
              c["box_max_mm"][2].get<double>());
  if (c["boundary_edges"].get<long>() > 0)
    std::printf(", %ld boundary edges", c["boundary_edges"].get<long>());
  if (c["open_sheet"].get<bool>())
    std::printf(
        ", an open sheet: the winding of its triangles defines its outside (winding = \"inward\" reverses "
        "it)");
  if (c["degenerate_faces_dropped"].get<long>() > 0) {
    std::printf(", %ld degenerate faces dropped", c["degenerate_faces_dropped"].get<long>());
  }
  if (c["identical_triangles_dropped"].get<long>() > 0)
    std::printf(", %ld identical triangles dropped", c["identical_triangles_dropped"].get<long>());
  if (c["turned_outward"].get<bool>()) std::printf(", turned outward");
  std::printf("\n");
}

void print_coordinates(const Json& coordinates)
{
  if (coordinates.is_null()) return;
  if (coordinates.contains("frames")) {
    const Json& frames = coordinates["frames"];
    std::printf("  %ld frames, %s %g to %g\n", frames["count"].get<long>(),
                frames["key"].get<std::string>().c_str(), frames["from"].get<double>(),
                frames["to"].get<double>());
  }
  for (const char* name : joint_coordinate_names) {
    std::printf("  %-9s  %s\n", name, coordinates["roles"][name].get<std::string>().c_str());
  }
}

void print_axis(const char* name, const Json& axis)
{
  if (axis.is_null()) {
    std::printf("  %-8s free\n", name);
    return;
  }
  std::printf("  %-8s %g to %g degrees, %ld values\n", name, axis["from_deg"].get<double>(),
              axis["to_deg"].get<double>(), axis["count"].get<long>());
}

void print_ligaments(const Json& l)
{
  if (l.is_null()) {
    std::printf("ligaments: none\n");
    return;
  }
  std::printf("ligaments: %d fibres in %zu bundles, %zu wraps\n", l["fibres"].get<int>(), l["bundles"].size(),
              l["wraps"].size());
  for (const Json& bundle : l["bundles"]) {
    std::printf("  %-18s %d fibres\n", bundle["name"].get<std::string>().c_str(),
                bundle["fibres"].get<int>());
  }
  for (const Json& wrap : l["wraps"]) {
    std::printf("  %-18s %s on the %s object, for %d fibres\n", wrap["name"].get<std::string>().c_str(),
                wrap["shape"].get<std::string>().c_str(), wrap["body"].get<std::string>().c_str(),
                wrap["fibres"].get<int>());
  }
}

void print_method(const Json& u)
{
  if (const Json& s = u["steps"]; !s.is_null()) {
    std::printf("  translation %g mm to %g mm, rotation %g to %g degrees\n",
                s["translation_mm"].get<double>(), s["translation_resolution_mm"].get<double>(),
                s["rotation_deg"].get<double>(), s["rotation_resolution_deg"].get<double>());
    return;
  }
  const Json& e = u["equilibrium"];
  std::printf("  tolerance %g mm in at most %d iterations, contact resolution %g mm\n",
              e["tolerance_mm"].get<double>(), e["max_iterations"].get<int>(),
              e["contact_resolution_mm"].get<double>());
  std::printf("  along the spine %d restarts per flexion, rotation band for %g N mm\n",
              e["restarts"].get<int>(), e["band_moment_nmm"].get<double>());
}

void print(const Json& u)
{
  std::printf("%s: %s, %s side, %s\n", u["title"].get<std::string>().c_str(),
              u["joint"].get<std::string>().c_str(), u["side"].get<std::string>().c_str(),
              u["method"].get<std::string>().c_str());
  const Json& o = u["rotation_centre_mm"];
  std::printf("rotation centre [%.2f %.2f %.2f] mm, canonical axes\n", o[0].get<double>(), o[1].get<double>(),
              o[2].get<double>());
  for (const char* body : {"reference", "moving"}) {
    if (u["found_frames"].is_null()) break;
    const Json& frame = u["found_frames"][body];
    std::printf("%s.frame found: origin %s, align rotation %s degrees\n", body,
                number_text(frame["origin"]).c_str(), number_text(frame["rotation_deg"]).c_str());
  }
  run::print_scaling(u["scaling"]);
  if (const auto note = u["scaling_note"].get<std::string>(); !note.empty())
    std::printf("  %s\n", note.c_str());
  std::printf("components\n");
  for (const Json& c : u["components"]) print_component(c);
  const Json& start = u["initial_pose"];
  if (start["overlapping"].get<bool>()) {
    std::printf("initial pose: the objects overlap by %.3f mm along Delta; the first step retreats\n",
                -start.value("travel_along_delta_mm", 0.0));
  } else if (start["travel_along_delta_mm"].is_null()) {
    std::printf("initial pose: the reference is not along Delta\n");
  } else {
    std::printf("initial pose: %.3f mm along Delta to the first contact\n",
                start["travel_along_delta_mm"].get<double>());
  }
  print_ligaments(u["ligaments"]);
  print_push(u["push"], !u["equilibrium"].is_null());
  std::printf("plan: %ld attitudes\n", u["grid"]["attitudes"].get<long>());
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
  const Json result = job_json(job_case, checked.initial, job.push);
  if (!options.picture.empty()) write_picture(options.picture, job_case, job, job_case.warnings.size());
  return result;
}

core::ExitCode check_command(const CheckOptions& options)
{
  const Json result = check_json(options);
  if (options.as_json) {
    std::printf("%s\n", core::json_text(result, 2).c_str());
  } else {
    print(result);
  }
  return core::ExitCode::done;
}

}  // namespace vrda::app
