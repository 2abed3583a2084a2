#include "app/check_command.hpp"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "assemble/prepare.hpp"
#include "core/units.hpp"
#include "proximity/directional_gap.hpp"
#include "run/scaling_text.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> numbers(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

// The two objects where the job puts them before the first step.
Json initial_pose_of(const Joint& joint, const SweepPlan& plan, const SearchOptions& search)
{
  NarrowPhase narrow_phase;
  const TreeMesh reference = turned(joint.reference.solid, {plan.flexion_rad.front(), 0.0});
  const bool is_overlapping =
      find_collision(reference, joint.moving.solid, plan.initial, narrow_phase).has_value();
  const Gap gap = directional_gap(reference, joint.moving.solid.mesh, joint.moving.solid.tree, plan.initial,
                                  {is_overlapping ? GapKind::from_afar : GapKind::from_here, {}});
  Json result = {{"overlapping", is_overlapping},
                 {"travel_along_delta_mm", std::isfinite(gap.travel_mm) ? Json(gap.travel_mm) : Json()},
                 {"substep_mm", joint.substep_mm},
                 {"approach_step_mm", search.approach_step_mm}};
  return result;
}

// Enough to say that a component is not sound; the exact number says little more.
constexpr std::size_t most_overlaps = 100;

// Triangles of one component that cross each other: the thickness of such a part means nothing.
void warn_of_self_overlaps(const Body& body, Json& warnings)
{
  NarrowPhase narrow_phase;
  for (std::size_t c = 0; c < body.components.size(); ++c) {
    std::vector<Eigen::Index> rows;
    for (std::size_t t = 0; t < body.contact.component.size(); ++t) {
      if (body.contact.component[t] == static_cast<std::int32_t>(c))
        rows.push_back(static_cast<Eigen::Index>(t));
    }
    if (rows.empty()) continue;
    const std::size_t n = find_self_overlaps(make_tree_mesh(with_triangles(body.contact.mesh, rows)),
                                             narrow_phase, most_overlaps)
                              .size();
    if (n == 0) continue;
    warnings.push_back(body.name + " component \"" + body.components[c].name +
                       "\": its own triangles cross each other in " +
                       (n == most_overlaps ? "at least " : "") + std::to_string(n) + " place(s)");
  }
}

Json component_json(const ComponentSurvey& c)
{
  return {{"body", c.body},
          {"name", c.name},
          {"source", c.source},
          {"contact", c.has_contact},
          {"triangles", c.n_triangles},
          {"vertices", c.n_vertices},
          {"closed", c.n_boundary_edges == 0},
          {"boundary_edges", c.n_boundary_edges},
          {"non_manifold_edges", c.n_non_manifold_edges},
          {"vertices_welded", c.n_welded},
          {"degenerate_faces_dropped", c.n_degenerate},
          {"turned_outward", c.was_flipped},
          {"box_min_mm", numbers(c.box.min_mm)},
          {"box_max_mm", numbers(c.box.max_mm)},
          {"mean_edge_mm", c.mean_edge_mm},
          {"volume_mm3", c.n_boundary_edges == 0 ? Json(c.volume_mm3) : Json()}};
}

Json axis_json(const std::vector<double>& values)
{
  return {{"from_deg", values.front()}, {"to_deg", values.back()}, {"count", values.size()}};
}

Json understood(const Case& job_case)
{
  const SweepPlan plan = plan_of(job_case);
  const SearchOptions& s = job_case.search;
  Json components = Json::array();
  for (const ComponentSurvey& c : job_case.survey) components.push_back(component_json(c));
  return {{"title", job_case.title},
          {"joint", job_case.joint},
          {"side", job_case.frame.side == Side::left ? "left" : "right"},
          {"method", job_case.method},
          {"rotation_centre_mm", numbers(job_case.frame.rotation_centre_mm)},
          {"delta", numbers(job_case.frame.delta)},
          {"scaling", scaling_json(job_case.scaling)},
          {"scaling_note", scaling_line(job_case)},
          {"components", components},
          {"initial_pose", initial_pose_of(joint_of(job_case, job_case.frame), plan, s)},
          {"grid",
           {{"flexion", axis_json(job_case.grid.flexion_deg)},
            {"varus", axis_json(job_case.grid.varus_deg)},
            {"attitudes", plan.flexion_rad.size() * plan.varus_rad.size()}}},
          {"steps",
           {{"translation_mm", s.translation_step_mm},
            {"translation_resolution_mm", s.translation_resolution_mm},
            {"rotation_deg", deg_from_rad(s.rotation_step_rad)},
            {"rotation_resolution_deg", deg_from_rad(s.rotation_resolution_rad)}}},
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
  if (c["degenerate_faces_dropped"].get<long>() > 0) {
    std::printf(", %ld degenerate faces dropped", c["degenerate_faces_dropped"].get<long>());
  }
  if (c["turned_outward"].get<bool>()) std::printf(", turned outward");
  std::printf("\n");
}

void print_axis(const char* name, const Json& axis)
{
  std::printf("  %-8s %g to %g degrees, %ld values\n", name, axis["from_deg"].get<double>(),
              axis["to_deg"].get<double>(), axis["count"].get<long>());
}

void print(const Json& u)
{
  std::printf("%s: %s, %s side, %s\n", u["title"].get<std::string>().c_str(),
              u["joint"].get<std::string>().c_str(), u["side"].get<std::string>().c_str(),
              u["method"].get<std::string>().c_str());
  const Json& o = u["rotation_centre_mm"];
  std::printf("rotation centre [%.2f %.2f %.2f] mm, canonical axes\n", o[0].get<double>(), o[1].get<double>(),
              o[2].get<double>());
  print_scaling(u["scaling"]);
  if (const auto note = u["scaling_note"].get<std::string>(); !note.empty())
    std::printf("  %s\n", note.c_str());
  std::printf("components\n");
  for (const Json& c : u["components"]) print_component(c);
  const Json& start = u["initial_pose"];
  if (start["overlapping"].get<bool>()) {
    std::printf("initial pose: the objects overlap, %.3f mm deep along Delta; the first step backs out\n",
                -start.value("travel_along_delta_mm", 0.0));
  } else if (start["travel_along_delta_mm"].is_null()) {
    std::printf("initial pose: nothing of the reference lies along Delta\n");
  } else {
    std::printf("initial pose: %.3f mm along Delta to the first touch\n",
                start["travel_along_delta_mm"].get<double>());
  }
  std::printf("plan: %ld attitudes\n", u["grid"]["attitudes"].get<long>());
  print_axis("flexion", u["grid"]["flexion"]);
  print_axis("varus", u["grid"]["varus"]);
  const Json& s = u["steps"];
  std::printf("  translation %g mm to %g mm, rotation %g to %g degrees\n", s["translation_mm"].get<double>(),
              s["translation_resolution_mm"].get<double>(), s["rotation_deg"].get<double>(),
              s["rotation_resolution_deg"].get<double>());
  for (const Json& w : u["warnings"]) std::printf("warning: %s\n", w.get<std::string>().c_str());
}

}  // namespace

ExitCode check_command(const CheckOptions& options)
{
  const Case job_case = of_subject(load_case(options.job_file, {options.data_directory, options.overrides}));
  Json result = understood(job_case);
  if (result["initial_pose"]["overlapping"].get<bool>()) {
    result["warnings"].push_back(
        "the objects overlap in the initial pose; initial.translation_mm may want a larger shift");
  }
  if (!result["initial_pose"]["overlapping"].get<bool>() &&
      result["initial_pose"]["travel_along_delta_mm"].is_null()) {
    result["warnings"].push_back(
        "nothing of the reference lies along Delta from the initial pose: no attitude can be solved");
  }
  warn_of_self_overlaps(job_case.reference, result["warnings"]);
  warn_of_self_overlaps(job_case.moving, result["warnings"]);
  if (options.as_json) {
    std::printf("%s\n", result.dump(2).c_str());
  } else {
    print(result);
  }
  return ExitCode::done;
}

}  // namespace vrda
