// `vrda smooth` and `vrda audit`: both add to the motion model that they read.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "analysis/audit.hpp"
#include "analysis/smooth.hpp"
#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "report/model_json.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

/// `vrda audit`: measures gap and penetration of the motions in a motion model.
struct AuditOptions {
  std::string file;
  std::string set = "all";  ///< one of set_names of store/motion.hpp, or "all"
  int refine = 1;           ///< subdivisions of each grid cell along each axis
  int n_threads = 0;        ///< 0: one per processor
  bool as_json = false;
};

// Reports the audits that were dropped with a changed set.
void report_dropped_audits(const std::vector<store::AuditSet>& before,
                           const std::vector<store::AuditSet>& after)
{
  for (const store::AuditSet& audit : before) {
    const bool is_there = std::any_of(after.begin(), after.end(),
                                      [&](const store::AuditSet& other) { return other.name == audit.name; });
    if (!is_there) core::log_info("dropped /audit/" + audit.name + ", which measured the replaced set");
  }
}

// Null without a travel.
Json travels_json(const std::optional<store::GridD>& recontact_mm)
{
  if (!recontact_mm) return {};
  Eigen::Index n = 0;
  double least_mm = 0.0, largest_mm = 0.0, sum_sq_mm2 = 0.0;
  for (Eigen::Index cell = 0; cell < recontact_mm->size(); ++cell) {
    const double mm = recontact_mm->data()[cell];
    if (std::isnan(mm)) continue;
    least_mm = n == 0 ? mm : std::min(least_mm, mm);
    largest_mm = n == 0 ? mm : std::max(largest_mm, mm);
    sum_sq_mm2 += mm * mm;
    ++n;
  }
  return {{"attitudes", recontact_mm->size()},
          {"without_contact", recontact_mm->size() - n},
          {"least_travel_mm", least_mm},
          {"largest_travel_mm", largest_mm},
          {"rms_travel_mm", n > 0 ? std::sqrt(sum_sq_mm2 / static_cast<double>(n)) : 0.0}};
}

Json surfaces_json(const std::vector<store::SmoothedSurface>& surfaces)
{
  Json json = Json::object();
  for (const store::SmoothedSurface& s : surfaces) {
    json[s.name] = {{"rms", s.rms},
                    {"largest_residual", s.largest_residual},
                    {"leave_one_out_rms", s.leave_one_out_rms},
                    {"cells", s.n_cells},
                    {"condition_number", s.condition_number}};
  }
  return json;
}

}  // namespace

Json json_of(const store::SmoothedSet& set)
{
  Json json = {{"degree", set.degree},
               {"robust", set.is_robust},
               {"surfaces", surfaces_json(set.surfaces)},
               {"recontact", travels_json(set.recontact_mm)}};
  for (const store::SmoothedFollower& follower : set.followers)
    json["followers"][follower.name] = {{"surfaces", surfaces_json(follower.surfaces)},
                                        {"recontact", travels_json(follower.recontact_mm)}};
  return json;
}

namespace {

void print_surfaces(const std::vector<store::SmoothedSurface>& surfaces, int width)
{
  std::printf("  %-*s %-10s %-10s %-14s %-6s %s\n", width, "", "RMS", "largest", "leave-one-out", "cells",
              "condition");
  for (const store::SmoothedSurface& s : surfaces) {
    std::printf("  %-*s %-10.4g %-10.4g %-14.4g %-6d %.3g\n", width, s.name.c_str(), s.rms,
                s.largest_residual, s.leave_one_out_rms, s.n_cells, s.condition_number);
  }
}

void print_travels(const std::optional<store::GridD>& recontact_mm)
{
  if (!recontact_mm) return;
  print_filled(
      "recontacted: travel along Delta {least_travel_mm%.4g} to {largest_travel_mm%.4g} mm, RMS "
      "{rms_travel_mm%.4g}; {without_contact} of {attitudes} attitudes without contact\n",
      travels_json(recontact_mm));
}

void print(const store::SmoothedSet& set)
{
  std::printf("smoothed, degree %d: %d terms%s; mm and degrees\n", set.degree,
              static_cast<int>(set.exponents.rows()), set.is_robust ? ", robust" : "");
  print_surfaces(set.surfaces, 6);
  print_travels(set.recontact_mm);
  for (const store::SmoothedFollower& follower : set.followers) {
    std::printf("%s\n", follower.name.c_str());
    print_surfaces(follower.surfaces, 14);
    print_travels(follower.recontact_mm);
  }
}

}  // namespace

std::optional<store::SmoothedSet> add_smoothed(const SmoothCommandOptions& options)
{
  const std::optional<OutputLock> lock = run::lock_output(options.file, "vrda smooth");
  if (!lock) return std::nullopt;
  store::MotionModel model = run::read_solved_model(options.file);
  store::require_grid(model, options.file, "vrda smooth");
  analysis::SmoothFit fit =
      analysis::smooth_fit(analysis::smooth_input(model, options.file), options.degree, {options.is_robust});
  if (std::find(fit.is_converged.begin(), fit.is_converged.end(), false) != fit.is_converged.end())
    core::log_warning("the robust weights did not converge within the iteration limit");
  store::SmoothedSet set = std::move(fit.set);
  if (options.is_recontacted)
    analysis::add_recontact(model, set, run::thread_count_or_all(options.n_threads));
  const std::vector<store::AuditSet> audits = model.audits;
  model = store::with_smoothed(std::move(model), set);
  // `run` compared the two-sided motion, which this set does not change.
  if (!model.two_sided)
    model = run::with_default_motion(std::move(model), set.is_robust,
                                     run::thread_count_or_all(options.n_threads));
  store::write_motion_model(options.file, model);
  report_dropped_audits(audits, model.audits);
  core::log_info(run::default_motion_line(model));
  return set;
}

core::ExitCode smooth_command(const SmoothCommandOptions& options)
{
  const std::optional<store::SmoothedSet> set = add_smoothed(options);
  if (!set) return core::ExitCode::interrupted;
  if (options.as_json) return print_json(json_of(*set));
  print(*set);
  return core::ExitCode::done;
}

void print_two_sided(const std::vector<std::pair<std::string, store::TwoSidedFigures>>& motions)
{
  constexpr const char* row = "%-22s %-17s %-11s %-15s %-12s %s\n";
  const auto number = [](double mm) { return formatted("%.3g", mm); };
  bool has_heading = false;
  for (const auto& [name, f] : motions) {
    if (f.n_poses == 0) continue;
    if (!has_heading) {
      std::printf(
          "both compartments in contact: attitudes with both gaps within %g mm; largest gap and overlap "
          "(mm)\n",
          perceptible_mm);
      std::printf(row, "set", "both in contact", "gap medial", "overlap medial", "gap lateral",
                  "overlap lateral");
      has_heading = true;
    }
    std::printf(row, name.c_str(),
                (std::to_string(f.n_both_in_contact) + " of " + std::to_string(f.n_poses)).c_str(),
                number(f.largest_gap_mm[0]).c_str(), number(f.largest_overlap_mm[0]).c_str(),
                number(f.largest_gap_mm[1]).c_str(), number(f.largest_overlap_mm[1]).c_str());
  }
}

namespace {

std::vector<std::string> chosen_sets(const store::MotionModel& model, const AuditOptions& options)
{
  const std::vector<std::string> names = store::set_names(model);
  if (options.set == "all") return names;
  if (std::find(names.begin(), names.end(), options.set) != names.end()) return {options.set};
  throw InputError({options.file, "--set", options.set, "one of all, " + joined(names)});
}

Json json_of(const analysis::AuditExtreme& extreme, int n)
{
  if (n == 0) return {};
  Json json = {
      {"mm", extreme.value_mm}, {"flexion_deg", extreme.flexion_deg}, {"varus_deg", extreme.varus_deg}};
  if (!std::isnan(extreme.key)) json["key"] = extreme.key;
  return json;
}

void add_figures(Json& json, const analysis::AuditFigures& f)
{
  json["poses"] = f.n_poses;
  json["overlapping"] = f.n_overlapping;
  json["nothing_ahead"] = f.n_nothing_ahead;
  json["largest_penetration"] = json_of(f.largest_penetration, f.n_overlapping);
  if (json.contains("set"))
    json["mean_penetration_mm"] = f.n_overlapping > 0 ? Json(f.mean_penetration_mm) : Json();
  json["largest_gap"] = json_of(f.largest_gap, f.n_free());
}

Json json_of(const store::AuditSet& set)
{
  const analysis::AuditFigures f = analysis::figures_of(set);
  Json json = {{"set", set.name}, {"refine", set.refine}, {"attitudes", set.state.size()}};
  add_figures(json, f);
  json["mean_gap_mm"] = f.n_free() > 0 ? Json(f.mean_gap_mm) : Json();
  json["two_sided"] = report::two_sided_json(f.two_sided);
  for (const store::FollowerAudit& follower : set.followers)
    add_figures(json["followers"][follower.name], analysis::figures_of(set, follower));
  return json;
}

// "0.0123 at 45, -2.5", or a dash.
std::string text_of(const analysis::AuditExtreme& extreme, int n)
{
  if (n == 0) return "-";
  if (!std::isnan(extreme.key)) return printed("%.3g at %g", extreme.value_mm, extreme.key);
  return printed("%.3g at %g, %g", extreme.value_mm, extreme.flexion_deg, extreme.varus_deg);
}

std::string mean_text(double mean_mm, int n)
{
  return n == 0 ? "-" : formatted("%.3g", mean_mm);
}

Json travel_json(const store::MotionModel& model)
{
  if (!model.frames) return {};
  const analysis::FrameTravel t = analysis::frame_travel(model);
  return {{"steps", t.n_steps},
          {"largest_mm", t.largest_mm},
          {"at_key_mm", std::isnan(t.key_of_mm) ? Json() : Json(t.key_of_mm)},
          {"mean_mm", t.mean_mm},
          {"largest_deg", deg_from_rad(t.largest_rad)},
          {"at_key_deg", std::isnan(t.key_of_rad) ? Json() : Json(t.key_of_rad)},
          {"mean_deg", deg_from_rad(t.mean_rad)}};
}

void print_travel(const store::MotionModel& model)
{
  if (!model.frames) return;
  print_filled(
      "from frame to frame: at most {largest_mm%.3g} mm (mean {mean_mm%.3g}) and {largest_deg%.3g} degrees "
      "(mean {mean_deg%.3g}), of the point at the rotation centre\n",
      travel_json(model));
}

// "1 mm in meniscus_medial" for each component with an allowed overlap.
std::vector<std::string> soft_parts(const store::MotionModel& model)
{
  std::vector<std::string> parts;
  for (const Body* body : {&model.reference, &model.moving}) {
    const auto triangles = triangles_by_component(*body, body->contact);
    for (std::size_t c = 0; c < triangles.size(); ++c) {
      const double depth_mm = triangles[c].empty() ? 0.0 : overlap_mm(body->contact.mesh, triangles[c][0]);
      if (depth_mm > 0.0) parts.push_back(shortest_decimal(depth_mm) + " mm in " + body->components[c].name);
    }
  }
  return parts;
}

void print_soft_parts(const store::MotionModel& model)
{
  const std::vector<std::string> parts = soft_parts(model);
  if (parts.empty()) return;
  std::printf("soft: up to %s; gaps and penetration are measured from there\n", joined(parts).c_str());
}

void print(const std::vector<store::AuditSet>& sets)
{
  constexpr const char* row = "%-22s %6s %8s %11s  %-24s %-10s %-24s %-10s %s\n";
  const bool has_frames = !sets.empty() && !sets.front().frame_key.empty();
  std::printf("lengths in mm along Delta, %s\n",
              has_frames ? "frames by their key" : "attitudes as flexion, varus in degrees");
  std::printf(row, "set", "refine", "poses", "overlapping", "largest penetration", "mean", "largest gap",
              "mean", "nothing ahead");
  const auto print_row = [&](const std::string& name, const store::AuditSet& set,
                             const analysis::AuditFigures& f) {
    std::printf(
        row, name.c_str(), std::to_string(set.refine).c_str(), std::to_string(f.n_poses).c_str(),
        std::to_string(f.n_overlapping).c_str(), text_of(f.largest_penetration, f.n_overlapping).c_str(),
        mean_text(f.mean_penetration_mm, f.n_overlapping).c_str(), text_of(f.largest_gap, f.n_free()).c_str(),
        mean_text(f.mean_gap_mm, f.n_free()).c_str(), std::to_string(f.n_nothing_ahead).c_str());
  };
  for (const store::AuditSet& set : sets) {
    print_row(set.name, set, analysis::figures_of(set));
    for (const store::FollowerAudit& follower : set.followers)
      print_row("  " + follower.name, set, analysis::figures_of(set, follower));
  }
  std::vector<std::pair<std::string, store::TwoSidedFigures>> motions;
  for (const store::AuditSet& set : sets) motions.emplace_back(set.name, store::two_sided_figures(set));
  print_two_sided(motions);
}

}  // namespace

core::ExitCode audit_command(const AuditOptions& options)
{
  const bool is_stored = run::may_add_to(options.file);
  const std::optional<OutputLock> lock =
      is_stored ? run::lock_output(options.file, "vrda audit") : std::nullopt;
  if (is_stored && !lock) return core::ExitCode::interrupted;
  store::MotionModel model = run::read_solved_model(options.file);
  const int n_threads = run::thread_count_or_all(options.n_threads);
  analysis::AuditScenes scenes(model, n_threads);
  const analysis::Measuring with(n_threads, &scenes);
  std::vector<store::AuditSet> measured;
  for (const std::string& set : chosen_sets(model, options))
    measured.push_back(analysis::audit(model, set, options.refine, with));
  for (const store::AuditSet& set : measured) model.audits = store::with_audit(std::move(model.audits), set);
  if (is_stored) store::write_motion_model(options.file, model);
  if (!options.as_json) {
    print(measured);
    print_soft_parts(model);
    print_travel(model);
    return core::ExitCode::done;
  }
  Json list = Json::array();
  for (const store::AuditSet& set : measured) list.push_back(json_of(set));
  if (model.frames) list.front()["travel"] = travel_json(model);
  return print_json(list);
}

void declare_smooth(Command& c)
{
  auto& o = c.options<SmoothCommandOptions>();
  c.model(o.file);
  c.option("--degree", o.degree, "Total degree of the polynomials")
      .required()
      .whole_number(0, store::max_smoothed_degree);
  c.flag("--robust", o.is_robust, "Reduce the weight of outliers (Huber)");
  c.flag("--recontact", o.is_recontacted, "Also find the travel along Delta into contact at every attitude");
  c.threads(o.n_threads);
  c.json(o.as_json);
  c.runs([&o] { return smooth_command(o); });
}

void declare_audit(Command& c)
{
  auto& o = c.options<AuditOptions>();
  c.model(o.file);
  c.option("--set", o.set, "two_sided, raw, degree_N, degree_N_recontacted, zero_varus or all")
      .shows_default();
  c.option("--refine", o.refine, "Subdivisions of each grid cell along each axis")
      .whole_number(1, 100)
      .shows_default();
  c.threads(o.n_threads);
  c.json(o.as_json);
  c.runs([&o] { return audit_command(o); });
}

}  // namespace vrda::app
