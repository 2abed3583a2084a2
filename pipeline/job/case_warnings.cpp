#include "job/case_warnings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "model/joint_kind.hpp"
#include "core/text.hpp"
#include "job/unit_check.hpp"

namespace vrda::job {
namespace {

using Warnings = std::vector<std::string>;

std::string one_decimal(double value)
{
  std::string digits(64, '\0');
  const auto [end, error] =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, 1);
  return error == std::errc() ? digits.substr(0, static_cast<std::size_t>(end - digits.data()))
                              : "very large";
}

void warn_of_steps(const Job& job, Warnings& warnings)
{
  constexpr double fewest = 10.0 * (1.0 - 1e-9);  // rounding of 0.1 degree in radians
  const auto compare = [&](const char* what, double step, double resolution) {
    if (step >= fewest * resolution) return;
    warnings.push_back(std::string("solver.search: the ") + what + " step is " +
                       one_decimal(step / resolution) +
                       " times its resolution; the search needs at least ten times for its step halving");
  };
  compare("translation", job.search.translation_step_mm, job.search.translation_resolution_mm);
  compare("rotation", job.search.rotation_step_rad, job.search.rotation_resolution_rad);
}

// Whether the job file or an override sets the key or a part of it. `root`: the file without defaults.
bool is_given(const Job& job, const core::DocumentValue& root, const std::string& key)
{
  for (const std::string& given : job.document.overridden) {
    if (given == key || given.starts_with(key + ".")) return true;
  }
  return core::find_at(root, key) != nullptr;
}

constexpr const char* search_keys[] = {"approach_step_mm",
                                       "translation_step_mm",
                                       "translation_resolution_mm",
                                       "rotation_step_deg",
                                       "rotation_resolution_deg",
                                       "points",
                                       "normals",
                                       "max_steps"};

// Keys that the selected method ignores.
void warn_of_other_method(const Job& job, const core::DocumentValue& root, Warnings& warnings)
{
  if (job.method == SolverMethod::equilibrium) {
    std::vector<std::string> given;
    for (const char* name : search_keys) {
      const std::string key = std::string("solver.search.") + name;
      if (is_given(job, root, key)) given.push_back(key);
    }
    // Every key: a resolved job, as `vrda fit` writes it.
    const bool is_overridden = std::ranges::any_of(
        job.document.overridden, [](const std::string& key) { return key.starts_with("solver.search"); });
    if (given.size() == std::size(search_keys) && !is_overridden) return;
    for (const std::string& key : given)
      warnings.push_back(key + ": it has no effect on the equilibrium method");
    return;
  }
  if (job.ligaments) {
    warnings.push_back("ligaments: they have no effect on the stability search, which uses contact only");
  }
  for (const char* key : {"push.force_n", "push.lateral_force_n", "push.moment_nmm", "push.varus_moment_nmm",
                          "push.point_mm", "push.load", "push.line", "solver.equilibrium"}) {
    if (is_given(job, root, key))
      warnings.push_back(std::string(key) +
                         ": it has no effect on the stability search, which uses directions of forces only");
  }
}

// The two axes of the lateral force are anterior and right for a proximal Delta only.
void warn_of_lateral_force(const Job& job, Warnings& warnings)
{
  if (job.method != SolverMethod::equilibrium || job.push.lateral_force_n.value.isZero(0.0)) return;
  const Eigen::Vector3d delta = job.push.delta.value.row(0);
  if (delta == Eigen::Vector3d::UnitY() && job.push.delta.value.rows() == 1) return;
  const Eigen::Matrix3d R = shortest_rotation(Eigen::Vector3d::UnitY(), delta);
  const auto shown = [](const Eigen::Vector3d& v) {
    std::string text;
    for (const double x : v)
      text += (text.empty() ? "[" : ", ") + shortest_decimal(std::round(1000.0 * x) / 1000.0 + 0.0);
    return text + "]";
  };
  warnings.push_back("push.lateral_force_n: it acts across push.delta, whose first direction is " +
                     shown(delta) + ": its two forces are along " + shown(R.col(0)) + " and " +
                     shown(R.col(2)) +
                     " there (anterior, proximal, right); [[push.load]] gives a force along any axes");
}

void warn_of_unused(const Job& job, Warnings& warnings)
{
  const core::DocumentValue root = core::parse_toml(job.text, job.file);
  warn_of_other_method(job, root, warnings);
  if (job.coordinates) return;  // their number of attitudes is known after loading
  const std::size_t n_flexion = job.grid.flexion_deg.size(), n_varus = job.grid.varus_deg.size();
  for (const std::int32_t degree : job.smooth_degrees) {
    if (static_cast<std::size_t>(degree) < n_fitted_angles(job.grid)) continue;
    warnings.push_back("smooth.degrees: degree " + std::to_string(degree) + " needs " +
                       std::to_string(degree + 1) + " angles on each axis; the grid has " +
                       std::to_string(n_flexion) + " of flexion and " + std::to_string(n_varus) +
                       " of varus");
  }
}

std::string named(const ComponentSurvey& component)
{
  return component.body + " component \"" + component.name + "\" (" + component.source + ")";
}

void warn_of_edges(const ComponentSurvey& component, Warnings& warnings)
{
  // The border of an open sheet is no fault; vrda check states it.
  if (component.n_boundary_edges > 0 && !component.has_sheet) {
    warnings.push_back(named(component) + ": nearly closed, with small holes (boundary edges: " +
                       std::to_string(component.n_boundary_edges) + "); its outside is found by its volume");
  }
  if (component.n_non_manifold_edges > 0) {
    warnings.push_back(named(component) + ": edges with more than two faces or inconsistent winding: " +
                       std::to_string(component.n_non_manifold_edges));
  }
}

std::string measured(const ComponentSurvey& component)
{
  return named(component) + ": its bounding box measures " +
         shortest_decimal(std::round(diagonal_mm(component.box) * 1000.0) / 1000.0) + " mm across";
}

std::string unit_remedy(const FrameJob& frame, const std::string& unit)
{
  const std::string key = frame.key + ".unit";
  return "; " + key + " is \"" + frame.unit + "\", the size suggests \"" + unit + "\": " + key + " = \"" +
         unit + "\"";
}

// The frame of a component of the survey, which lists those of the reference first.
const FrameJob& frame_of_component(const Job& job, std::size_t index)
{
  return frame_of(job, index < job.reference.components.size() ? job.reference : job.moving);
}

void warn_of_size(const Job& job, const FrameJob& frame, const ComponentSurvey& component, Warnings& warnings)
{
  const SizeRange usual = usual_size_range(job);
  const double size_mm = diagonal_mm(component.box);
  if (size_mm >= usual.least_mm && size_mm <= usual.most_mm) return;
  const std::string unit = suggested_unit(frame.unit, size_mm, usual);
  warnings.push_back(measured(component) + (unit.empty() ? "" : unit_remedy(frame, unit)));
}

// Knee bones in cm, read as mm, have the size of menisci.
void warn_of_small_knee(const Job& job, const Case& loaded, Warnings& warnings)
{
  constexpr SizeRange whole_bone{50.0, 800.0};
  const auto largest = std::max_element(loaded.survey.begin(), loaded.survey.end(),
                                        [](const ComponentSurvey& a, const ComponentSurvey& b) {
                                          return diagonal_mm(a.box) < diagonal_mm(b.box);
                                        });
  const double size_mm = diagonal_mm(largest->box);
  if (job.joint != "knee" || size_mm >= whole_bone.least_mm || size_mm < usual_size_range(job).least_mm)
    return;
  const FrameJob& frame = frame_of_component(job, static_cast<std::size_t>(largest - loaded.survey.begin()));
  const std::string unit = suggested_unit(frame.unit, size_mm, whole_bone);
  warnings.push_back(measured(*largest) + ", the largest of the joint" +
                     (unit.empty() ? "" : unit_remedy(frame, unit)));
}

void warn_of_last_angle(const Job& job, const std::string& key, const std::vector<double>& angles_deg,
                        Warnings& warnings)
{
  const core::DocumentValue& root = job.document.root;
  const double to_deg = core::number_at(root, key + ".to"),
               step_deg = core::number_at(root, key + ".step");
  const double last_deg = angles_deg.back();
  constexpr double reached = 1e-6;  // of a step
  if (std::abs(to_deg - last_deg) <= reached * std::abs(step_deg)) return;
  warnings.push_back(key + ": steps of " + shortest_decimal(step_deg) + " from " +
                     shortest_decimal(angles_deg.front()) + " end at " + shortest_decimal(last_deg) +
                     ", before " + shortest_decimal(to_deg) + "; to = " + shortest_decimal(last_deg) +
                     ", to = " + shortest_decimal(last_deg + step_deg) +
                     ", or a step that divides the range");
}

// Such as 1.57 or 2.0944 instead of 90 or 120 degrees.
void warn_of_radians(const Job& job, Warnings& warnings)
{
  constexpr double step_deg = 15.0, rounding = 0.005;
  const double to = job.grid.flexion_deg.back();
  const double steps = std::round(deg_from_rad(to) / step_deg);
  const bool is_radians =
      steps >= 1.0 && to < 3.2 && std::abs(to - rad_from_deg(steps * step_deg)) < rounding;
  if (!is_radians) return;
  warnings.push_back(
      "grid.flexion: up to " + shortest_decimal(to) +
      " degrees; angles are in degrees; in radians this is to = " + shortest_decimal(steps * step_deg));
}

void warn_of_grid(const Job& job, Warnings& warnings)
{
  if (job.document.root.find("grid") == nullptr) return;
  warn_of_last_angle(job, "grid.flexion", job.grid.flexion_deg, warnings);
  if (!job.is_varus_free) warn_of_last_angle(job, "grid.varus", job.grid.varus_deg, warnings);
  warn_of_radians(job, warnings);
}

void warn_of_free_rotation(const Job& job, Warnings& warnings)
{
  if (job.method != SolverMethod::equilibrium || job.ligaments) return;
  if (job.is_varus_free && job.joint != "knee") return;  // congruent joints are held by their contact
  if (job.coordinates && (job.coordinates->coordinate[1].role == CoordinateRole::free ||
                          job.coordinates->coordinate[2].role != CoordinateRole::free))
    return;
  warnings.emplace_back(
      "ligaments: found none; the rotation about push.delta is nearly free; give "
      "[ligaments] with fibres = \"ligaments.csv\" (theta_determined marks where it is determined)");
}

void warn_of_range(const std::string& axis, const std::vector<double>& angles_deg, const AngleRange& usual,
                   const Job& job, Warnings& warnings)
{
  const auto [least, most] = std::minmax_element(angles_deg.begin(), angles_deg.end());
  const bool is_above = *most > usual.most_deg;
  if (!is_above && *least >= usual.least_deg) return;
  const bool has_grid = job.document.root.find("grid") != nullptr;
  warnings.push_back((has_grid ? "grid." : "coordinates.") + axis + ": " +
                     shortest_decimal(is_above ? *most : *least) + " degrees, no " + job.joint +
                     " goes there: it has " + shortest_decimal(usual.least_deg) + " to " +
                     shortest_decimal(usual.most_deg) +
                     " degrees (schemas/clinical.md), and contact beyond is where the surfaces end; " +
                     (is_above ? "to = " + shortest_decimal(usual.most_deg)
                               : "from = " + shortest_decimal(usual.least_deg)));
}

// The grid's angles, or those of a sequence's frames.
void warn_of_ranges(const Job& job, const Case& loaded, Warnings& warnings)
{
  const JointKind& kind = joint_kind(job.joint);
  warn_of_range("flexion", loaded.grid.flexion_deg, kind.usual_flexion, job, warnings);
  warn_of_range("varus", loaded.grid.varus_deg, kind.usual_varus, job, warnings);
}

std::vector<const ComponentJob*> all_components(const Job& job)
{
  std::vector<const ComponentJob*> all;
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    for (const ComponentJob& component : body->components) all.push_back(&component);
  }
  return all;
}

// Probably a copied job with generated parts left over.
void warn_of_generated_parts(const Job& job, Warnings& warnings)
{
  std::string keys;
  bool has_file = false;
  for (const ComponentJob* component : all_components(job)) {
    if (component->generate)
      keys += (keys.empty() ? "" : ", ") + component->key + " (\"" + component->name + "\")";
    else
      has_file = true;
  }
  if (!has_file) return;
  if (!keys.empty()) {
    warnings.push_back(keys +
                       ": generated part next to mesh files, with the size and position of another knee; "
                       "give file = \"...\" instead of generate, or remove it");
  }
  if (job.ligaments && job.ligaments->generate) {
    warnings.emplace_back(
        "ligaments.generate: generated fibres next to mesh files fit the bones of another knee; give "
        "fibres = \"ligaments.csv\" instead, or remove [ligaments]");
  }
}

// Two components with the same file: probably a copied line.
void warn_of_equal_files(const Job& job, const Case& loaded, Warnings& warnings)
{
  const std::vector<const ComponentJob*> components = all_components(job);
  std::map<std::string, std::string> sha256_of_name;
  for (const LoadedInput& input : loaded.inputs) sha256_of_name[input.name] = input.sha256;
  for (std::size_t i = 0; i < components.size(); ++i) {
    for (std::size_t j = i + 1; j < components.size(); ++j) {
      const bool are_files = !components[i]->generate && !components[j]->generate;
      if (!are_files || sha256_of_name[components[i]->file] != sha256_of_name[components[j]->file]) continue;
      warnings.push_back(components[j]->key + ".file: \"" + components[j]->file + "\" is the same mesh as " +
                         components[i]->key + ".file; name the mesh of \"" + components[j]->name + "\"");
    }
  }
}

}  // namespace

std::vector<std::string> case_warnings(const Job& job, const Case& loaded)
{
  Warnings warnings;
  if (job.has_campaign) {
    warnings.emplace_back(
        "campaign: ignored here, the job is used without it; vrda plan and vrda submit use the campaign");
  }
  if (job.method == SolverMethod::stability_search) warn_of_steps(job, warnings);
  warn_of_unused(job, warnings);
  warn_of_lateral_force(job, warnings);
  warn_of_grid(job, warnings);
  warn_of_ranges(job, loaded, warnings);
  warn_of_free_rotation(job, warnings);
  warn_of_generated_parts(job, warnings);
  warn_of_equal_files(job, loaded, warnings);
  for (std::size_t i = 0; i < loaded.survey.size(); ++i) {
    warn_of_edges(loaded.survey[i], warnings);
    warn_of_size(job, frame_of_component(job, i), loaded.survey[i], warnings);
  }
  warn_of_small_knee(job, loaded, warnings);
  return warnings;
}

}  // namespace vrda::job
