#include "job/case_warnings.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/text.hpp"
#include "geometry/nearest_surface.hpp"
#include "geometry/wrap_over.hpp"
#include "job/auto_frame.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"

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

// Keys that the selected method ignores.
void warn_of_other_method(const Job& job, const core::DocumentValue& root, Warnings& warnings)
{
  if (job.method == SolverMethod::equilibrium) {
    const core::DocumentValue& search = core::value_at(job.document.root, "solver.search");
    std::vector<std::string> given;
    for (const auto& [name, value] : search.items()) {
      const std::string key = "solver.search." + name;
      if (is_given(job, root, key)) given.push_back(key);
    }
    // Every key: a resolved job, as `vrda fit` writes it.
    const bool is_overridden = std::ranges::any_of(
        job.document.overridden, [](const std::string& key) { return key.starts_with("solver.search"); });
    if (given.size() == search.size() && !is_overridden) return;
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
    return "[" + core::numbers_text((1000.0 * v).array().round() / 1000.0 + 0.0) + "]";
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

void warn_of_edges(const ComponentSurvey& component, Warnings& warnings)
{
  for (const std::string& note : component.notes) warnings.push_back(named(component) + ": " + note);
  // The border of an open sheet is no fault; vrda check states it.
  if (component.n_boundary_edges > 0 && !component.has_sheet) {
    warnings.push_back(named(component) + ": nearly closed, with small holes (boundary edges: " +
                       std::to_string(component.n_boundary_edges) + ") " + component.boundary_places +
                       "; its outside is found by its volume");
  }
  if (component.n_non_manifold_edges > 0) {
    warnings.push_back(named(component) + ": edges with more than two faces or inconsistent winding: " +
                       std::to_string(component.n_non_manifold_edges) + ", " + component.non_manifold_places);
  }
}

std::string measured(const ComponentSurvey& component)
{
  return named(component) + ": its bounding box measures " + short_decimal(diagonal_mm(component.box), 3) +
         " mm across";
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
  const double to_deg = core::number_at(root, key + ".to"), step_deg = core::number_at(root, key + ".step");
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
  if (!job.document.root.contains("grid")) return;
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
  const bool has_grid = job.document.root.contains("grid");
  warnings.push_back((has_grid ? "grid." : "coordinates.") + axis + ": " +
                     short_decimal(is_above ? *most : *least, 6) + " degrees, no " + job.joint +
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

namespace {

void warn_of_overlap(const Job& job, Warnings& warnings)
{
  for (const BodyJob* body : {&job.reference, &job.moving}) {
    for (const ComponentJob& component : body->components) {
      if (!component.has_contact || component.overlap_mm == 0.0) continue;
      warnings.push_back(component.key + ".overlap_mm: soft: the other object may be inside \"" +
                         component.name + "\" by up to " + shortest_decimal(component.overlap_mm) +
                         " mm; gaps, contacts and overlaps are measured from there");
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
  warn_of_overlap(job, warnings);
  return warnings;
}

// Warnings about the axes, the side and the rotation centre of a joint, judged from its geometry.

namespace {

bool mentions(const std::string& name, const std::string& word)
{
  return lower_case(name).find(word) != std::string::npos;
}

// Whether the name of an object or of one of its components contains one of the words.
bool mentions(const Body& body, const std::vector<std::string>& words)
{
  std::vector<std::string> names{body.name};
  for (const Component& component : body.components) names.push_back(component.name);
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return mentions(name, word); });
  });
}

void warn_of_joint(const Job& job, const Case& loaded, Warnings& warnings)
{
  const std::vector<std::string> bones_elsewhere{"pelvis", "acetab", "scapula", "glenoid", "humer",
                                                 "talus",  "calcan", "ulna",    "vertebra"};
  const std::string names = "\"" + loaded.reference.name + "\" and \"" + loaded.moving.name + "\"";
  if (job.joint == "knee" &&
      (mentions(loaded.reference, bones_elsewhere) || mentions(loaded.moving, bones_elsewhere))) {
    warnings.push_back("joint: \"knee\", but the objects " + names +
                       " have names of other bones; for another joint write joint = \"hip\", \"ankle\", "
                       "\"subtalar\" or \"other\"");
  }
  if (job.joint != "knee" && mentions(loaded.reference, {"femur", "femoral"}) &&
      mentions(loaded.moving, {"tibia"})) {
    warnings.push_back("joint: \"" + job.joint + "\", but the objects " + names +
                       " have names of knee bones; joint = \"knee\" adds compartments and checks");
  }
}

Eigen::Vector3d middle_of(const Box& box)
{
  return 0.5 * (box.min_mm + box.max_mm);
}

// The signed axis of the files for a direction along canonical axis `k`.
std::string file_axis(const FrameJob& frame, Eigen::Index k, bool is_positive)
{
  const std::string& word = k == 0 ? frame.anterior : k == 1 ? frame.proximal : frame.right;
  return ((word.at(0) == '+') == is_positive ? "+" : "-") + word.substr(1);
}

std::string tenths_text(double value_mm)
{
  const std::string text = short_decimal(value_mm, 1);
  return text.find('.') == std::string::npos ? text + ".0" : text;
}

// The femur must be above the tibia. Returns true if a warning was added.
bool warn_of_axes(const Job& job, const Case& loaded, Warnings& warnings)
{
  const Eigen::Vector3d upward_mm = middle_of(bounding_box(loaded.reference.contact.mesh)) -
                                    middle_of(bounding_box(loaded.moving.contact.mesh));
  constexpr double min_ratio = 1.5;  // to the vertical distance, for a clear decision
  Eigen::Index k = 0;
  const double largest_mm = upward_mm.cwiseAbs().maxCoeff(&k);
  if (k == 1 && upward_mm.y() >= 0.0) return false;
  if (k != 1 && largest_mm < min_ratio * std::abs(upward_mm.y())) return false;
  constexpr double min_share = 0.2;  // of the smaller object: a shorter distance gives no clear direction
  const double smaller_mm = std::min(diagonal_mm(bounding_box(loaded.reference.contact.mesh)),
                                     diagonal_mm(bounding_box(loaded.moving.contact.mesh)));
  if (largest_mm < min_share * smaller_mm) return false;
  const bool is_exchanged =
      mentions(loaded.reference, {"tibia"}) || mentions(loaded.moving, {"femur", "femoral"});
  if (job.reference.frame || job.moving.frame) {
    warnings.push_back("frame: in the frames of both objects the reference \"" + loaded.reference.name +
                       "\" is not proximal of the moving object \"" + loaded.moving.name +
                       "\"; check origin, axes and align of both, or exchange [reference] and [moving]");
    return true;
  }
  const std::string axis = file_axis(job.frame, k, upward_mm[k] > 0.0);
  warnings.push_back("frame.proximal: the reference \"" + loaded.reference.name + "\" is along " + axis +
                     " of the files from the moving object \"" + loaded.moving.name + "\", not along " +
                     job.frame.proximal + "; " +
                     (is_exchanged ? "by their names [reference] and [moving] are exchanged"
                                   : "frame.proximal = \"" + axis +
                                         "\", with anterior and right to match, or exchange [reference] and "
                                         "[moving]"));
  return true;
}

// Delta pushes the moving object into the reference, which must be ahead of it.
void warn_of_exchange(const Case& loaded, Warnings& warnings)
{
  const Box reference = bounding_box(loaded.reference.contact.mesh);
  const Box moving = bounding_box(loaded.moving.contact.mesh);
  const double ahead_mm = (middle_of(reference) - middle_of(moving)).dot(loaded.push_at_meshes.delta);
  constexpr double min_share = 0.2;  // of the smaller object: a shorter distance gives no clear direction
  if (ahead_mm >= -min_share * std::min(diagonal_mm(reference), diagonal_mm(moving))) return;
  warnings.push_back("push.delta: it points away from the reference \"" + loaded.reference.name + "\", " +
                     tenths_text(-ahead_mm) + " mm behind the moving object \"" + loaded.moving.name +
                     "\"; reverse push.delta, or exchange [reference] and [moving]");
}

// Mean z of the components whose name contains a word; empty without such components.
std::optional<double> mean_z_mm(const std::vector<ComponentSurvey>& survey, const char* word,
                                const char* synonym)
{
  double sum = 0.0;
  int n = 0;
  for (const ComponentSurvey& component : survey) {
    if (!mentions(component.name, word) && !mentions(component.name, synonym)) continue;
    sum += middle_of(component.box).z();
    ++n;
  }
  return n == 0 ? std::nullopt : std::optional<double>(sum / n);
}

// On a right knee lateral is to the right; the fibula is lateral.
void warn_of_side(const Job& job, const Case& loaded, Warnings& warnings)
{
  const std::optional<double> medial_mm = mean_z_mm(loaded.survey, "medial", "medial");
  const std::optional<double> lateral_mm = mean_z_mm(loaded.survey, "lateral", "fibula");
  if (!medial_mm && !lateral_mm) return;
  const double centre_mm = loaded.frame.rotation_centre_mm.z();
  const double to_the_right_mm = lateral_mm.value_or(centre_mm) - medial_mm.value_or(centre_mm);
  const std::string found = side_name(to_the_right_mm > 0.0 ? Side::right : Side::left);
  const std::string given = side_name(job.side);
  if (to_the_right_mm == 0.0 || found == given) return;
  warnings.push_back("side: the job has \"" + given + "\", but the components named lateral are to the " +
                     found + " of those named medial, as in a " + found + " knee; side = \"" + found +
                     "\", unless frame.anterior and frame.right both have the wrong sign");
}

// A position as a value of the reference's origin, rounded to 0.1 mm.
std::string origin_text(const Job& job, const Eigen::Vector3d& p_mm)
{
  const AxisMap map = body_map(job, job.reference);
  const Eigen::Vector3d native = map.X_canonical_native.inverse() * p_mm / map.unit_mm;
  const double tenths = 10.0 * map.unit_mm;  // of a millimetre, in the files' unit
  std::string text;
  for (const double value : native)
    text += (text.empty() ? "" : ", ") + shortest_decimal(std::round(value * tenths) / tenths + 0.0);
  return frame_of(job, job.reference).key + ".origin = [" + text + "]";
}

// Centre of the intersection of two boxes, or of the gap between them.
Eigen::Vector3d middle_between(const Box& a, const Box& b)
{
  return 0.5 * (a.min_mm.cwiseMax(b.min_mm) + a.max_mm.cwiseMin(b.max_mm));
}

double distance_mm(const Eigen::Vector3d& p_mm, const Box& box)
{
  return (p_mm - p_mm.cwiseMax(box.min_mm).cwiseMin(box.max_mm)).norm();
}

// Without condyle spheres: a centre far from either object.
void warn_of_centre_off_objects(const Job& job, const Case& loaded, Warnings& warnings)
{
  // The centre of a hip is 30 mm inside its bones; an epicondylar axis is 50 mm from the patella.
  const double farthest_mm = job.joint == "knee" ? 60.0 : 100.0;
  const Box reference = bounding_box(loaded.reference.contact.mesh);
  const Box moving = bounding_box(loaded.moving.contact.mesh);
  const Eigen::Vector3d& centre_mm = loaded.frame.rotation_centre_mm;
  const bool is_reference = distance_mm(centre_mm, reference) > distance_mm(centre_mm, moving);
  const double off_mm = distance_mm(centre_mm, is_reference ? reference : moving);
  if (off_mm <= farthest_mm) return;
  warnings.push_back(frame_of(job, job.reference).key + ".origin: the rotation centre is " +
                     tenths_text(off_mm) + " mm from the box of " +
                     (is_reference ? loaded.reference.name : loaded.moving.name) +
                     "; the midpoint between both objects as a start value: " +
                     origin_text(job, middle_between(reference, moving)));
}

void warn_of_centre(const Job& job, const Case& loaded, Warnings& warnings)
{
  constexpr double farthest_mm = 30.0;  // from the midpoint of the condyles' centres, or the head's centre
  std::optional<Eigen::Vector3d> middle_mm;
  if (job.joint == "knee") {
    if (const auto spheres = condyle_spheres(loaded.reference.contact.mesh))
      middle_mm = 0.5 * (spheres->left.centre_mm + spheres->right.centre_mm);
  } else if (job.joint == "hip") {
    if (const auto head = head_sphere(loaded)) middle_mm = head->centre_mm;
  }
  if (!middle_mm) return warn_of_centre_off_objects(job, loaded, warnings);
  const double off_mm = (loaded.frame.rotation_centre_mm - *middle_mm).norm();
  if (off_mm <= farthest_mm) return;
  warnings.push_back(frame_of(job, job.reference).key + ".origin: the rotation centre is " +
                     tenths_text(off_mm) + " mm from the " +
                     (job.joint == "knee" ? "middle of the condyles" : "centre of the head") + ", which is " +
                     origin_text(job, *middle_mm));
}

}  // namespace

std::vector<std::string> anatomy_warnings(const Job& job, const Case& loaded)
{
  std::vector<std::string> warnings;
  warn_of_joint(job, loaded, warnings);
  const std::string shape = joint_shape_warning(job.joint, loaded);
  if (!shape.empty()) warnings.push_back(shape);
  // With wrong axes the checks of side and condyles are meaningless.
  if (job.joint == "knee" && warn_of_axes(job, loaded, warnings)) return warnings;
  if (job.joint == "knee") warn_of_side(job, loaded, warnings);
  if (job.joint != "knee") warn_of_exchange(loaded, warnings);
  warn_of_centre(job, loaded, warnings);
  return warnings;
}

// Warnings about implausible ligament fibres at the pose of the meshes.

namespace {

constexpr double infinity_mm = std::numeric_limits<double>::infinity();

// Distance from a mesh: exact if above `enough_mm`, otherwise an upper bound below it, since most attachments
// are near a vertex.
class SurfaceDistance {
 public:
  explicit SurfaceDistance(const Mesh& mesh) : mesh_(mesh) {}

  double operator()(const Eigen::Vector3d& p_mm, double enough_mm)
  {
    if (mesh_.vertices_mm.rows() == 0) return infinity_mm;
    const double to_vertex_mm =
        std::sqrt((mesh_.vertices_mm.rowwise() - p_mm.transpose()).rowwise().squaredNorm().minCoeff());
    if (to_vertex_mm <= enough_mm) return to_vertex_mm;
    if (!surface_) surface_.emplace(mesh_);
    return surface_->nearest(p_mm).distance_mm;
  }

 private:
  const Mesh& mesh_;
  std::optional<geometry::NearestSurface> surface_;
};

// Fibres of real knees attach up to 14 mm from tibia and femur (fibular attachments without a fibula mesh),
// those of a lateral malleolus without one up to 24 mm, and up to 25 mm from cartilage without bone meshes.
double farthest_attachment_mm(const Body& body, const std::string& joint)
{
  const bool has_bone = std::any_of(body.components.begin(), body.components.end(),
                                    [](const Component& c) { return c.material == "bone"; });
  if (!has_bone) return 30.0;
  return joint == "ankle" ? 25.0 : 20.0;
}

// "ligaments.csv: line 3, moving_mm: fibre "ACL" ".
std::string place_of(const FibreJob& fibre, const std::string& key)
{
  return fibre.source + ": " + fibre_key(fibre, key) + ": fibre \"" + fibre.name + "\" ";
}

std::string and_more(std::size_t n)
{
  return n > 1 ? " (and " + std::to_string(n - 1) + " more)" : "";
}

// One end of a fibre: its key in the job, its position and its object.
struct End {
  const char* key;
  Eigen::Vector3d model::Fibre::*place_mm;
  const Body* body;
};

void warn_of_far_attachments(const LoadedLigaments& loaded, const End& end, const std::string& joint,
                             Warnings& warnings)
{
  SurfaceDistance contact(end.body->contact.mesh), visual(end.body->visual.mesh);
  const double enough_mm = farthest_attachment_mm(*end.body, joint);
  std::size_t first = 0, n_far = 0;
  double first_mm = 0.0;
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const Eigen::Vector3d& p_mm = loaded.ligaments.fibres[i].*end.place_mm;
    const double off_mm = std::min(contact(p_mm, enough_mm), visual(p_mm, enough_mm));
    if (off_mm <= enough_mm) continue;
    if (n_far++ > 0) continue;
    first = i;
    first_mm = off_mm;
  }
  if (n_far == 0) return;
  warnings.push_back(place_of(loaded.jobs[first], end.key) + "attached " + short_decimal(first_mm, 1) +
                     " mm from the surface of " + end.body->name + and_more(n_far) +
                     "; attachments are in mm along the mesh files' axes, at most " +
                     shortest_decimal(enough_mm) + " mm from it");
}

void warn_of_scattered_bundles(const LoadedLigaments& loaded, const End& end, Warnings& warnings)
{
  constexpr double farthest_mm = 20.0;  // neighbours in a bundle of the real knees are within 10 mm
  constexpr int fewest_others = 2;      // with two fibres the wrong one is ambiguous
  const std::vector<model::Fibre>& fibres = loaded.ligaments.fibres;
  for (std::size_t i = 0; i < fibres.size(); ++i) {
    double nearest_mm = infinity_mm;
    int n_others = 0;
    for (std::size_t j = 0; j < fibres.size(); ++j) {
      if (j == i || fibres[j].bundle != fibres[i].bundle) continue;
      ++n_others;
      nearest_mm = std::min(nearest_mm, (fibres[i].*end.place_mm - fibres[j].*end.place_mm).norm());
    }
    if (n_others < fewest_others || nearest_mm <= farthest_mm) continue;
    warnings.push_back(place_of(loaded.jobs[i], end.key) + "attached " + short_decimal(nearest_mm, 1) +
                       " mm from the nearest other fibre of bundle \"" + fibres[i].bundle +
                       "\", wanted at most " + shortest_decimal(farthest_mm) +
                       " mm; is a sign or digit wrong?");
    return;
  }
}

// At the pose of the meshes (a scan); the real knees have strains from -0.14 to 0.11.
constexpr double largest_strain = 0.2;  // ligaments fail there: Butler et al. 1986, J Biomech 19:425-432
constexpr double least_strain = -0.5;

std::string strain_remedy(const FibreJob& fibre, double strain, double length_mm)
{
  if (!fibre.reference_strain) {
    return strain > 0.0 ? "; its length there is " + short_decimal(length_mm, 1) +
                              " mm, so slack_length_mm = " + short_decimal(length_mm / 1.03, 1) +
                              " for a strain of 0.03"
                        : "; its length there is " + short_decimal(length_mm, 1) + " mm";
  }
  return "; a strain is a fraction, 3 % is reference_strain = 0.03";
}

// [n_fibres] at the pose of the meshes.
std::vector<double> strains_of(const LoadedLigaments& loaded)
{
  std::vector<double> strains;
  const std::vector<model::FibreState> states = model::fibre_states(loaded.ligaments, {}, {});
  for (std::size_t i = 0; i < states.size(); ++i)
    strains.push_back(states[i].length_mm / loaded.ligaments.fibres[i].slack_length_mm - 1.0);
  return strains;
}

void warn_of_strains(const LoadedLigaments& loaded, const std::vector<double>& strains, Warnings& warnings)
{
  std::size_t first = 0, n_implausible = 0;
  for (std::size_t i = 0; i < strains.size(); ++i) {
    if (strains[i] >= least_strain && strains[i] <= largest_strain) continue;
    if (n_implausible++ == 0) first = i;
  }
  if (n_implausible == 0) return;
  const FibreJob& fibre = loaded.jobs[first];
  warnings.push_back(place_of(fibre, fibre.reference_strain ? "reference_strain" : "slack_length_mm") +
                     "has a strain of " + short_decimal(strains[first], 3) + " at the pose of the meshes" +
                     and_more(n_implausible) + "; ligaments have " + shortest_decimal(least_strain) + " to " +
                     shortest_decimal(largest_strain) +
                     strain_remedy(fibre, strains[first],
                                   (1.0 + strains[first]) * loaded.ligaments.fibres[first].slack_length_mm));
}

// The four ligaments of a knee that the names of its bundles mention, each with its largest strain.
std::map<std::string, double> largest_strains(const LoadedLigaments& loaded,
                                              const std::vector<double>& strains)
{
  std::map<std::string, double> largest;
  for (std::size_t i = 0; i < strains.size(); ++i) {
    const std::string name = model::ligament_of(loaded.ligaments.fibres[i].bundle);
    if (std::ranges::find(model::knee_ligaments, name) == std::end(model::knee_ligaments)) continue;
    const auto [at, is_new] = largest.emplace(name, strains[i]);
    if (!is_new) at->second = std::max(at->second, strains[i]);
  }
  return largest;
}

void warn_of_missing_ligaments(const std::map<std::string, double>& found, Warnings& warnings)
{
  std::vector<std::string> missing;
  for (const char* name : model::knee_ligaments) {
    if (!found.contains(name)) missing.emplace_back(name);
  }
  if (found.empty() || missing.empty()) return;
  warnings.push_back("ligaments: no bundle is named " + join_alternatives(missing, " and ") +
                     ": the knee is solved as if it were cut; add its fibres, or leave it out on purpose");
}

// The bundles of divided ligaments of which another bundle is there. A ligament with a bundle of another name
// is divided otherwise. The posterior MCL of some published tables is part of the capsule ("pMC").
void warn_of_missing_bundles(const LoadedLigaments& loaded, Warnings& warnings)
{
  std::set<std::string> found, divided_otherwise;
  bool has_posteromedial_capsule = false;
  for (const model::Fibre& fibre : loaded.ligaments.fibres) {
    const auto known = std::ranges::find_if(model::divided_bundles, [&](const std::string& name) {
      return lower_case(fibre.bundle) == lower_case(name);
    });
    if (known != std::end(model::divided_bundles)) {
      found.emplace(*known);
    } else {
      divided_otherwise.insert(model::ligament_of(fibre.bundle));
      has_posteromedial_capsule |= lower_case(fibre.bundle).starts_with("pmc");
    }
  }
  std::vector<std::string> missing;
  for (const std::string name : model::divided_bundles) {
    const std::string ligament = model::ligament_of(name);
    const bool is_divided = std::ranges::any_of(
        found, [&](const std::string& other) { return model::ligament_of(other) == ligament; });
    if (found.contains(name) || !is_divided || divided_otherwise.contains(ligament)) continue;
    if (name == "MCLp" && has_posteromedial_capsule) continue;
    missing.push_back(name);
  }
  if (missing.empty()) return;
  warnings.push_back("ligaments: no bundle is named " + join_alternatives(missing, " and ") +
                     ", but others of the same ligament are there: the knee is solved as if it were cut; add "
                     "its fibres, or leave it out on purpose");
}

// Of published knees, each ligament has a fibre with a strain of at least -0.03 at the reference pose
// (schemas/ligaments.md). A table whose slack lengths are 1.2 times too long has -0.12 at most.
constexpr double slack_strain = -0.08;

void warn_of_slack_ligaments(const std::map<std::string, double>& largest, const std::vector<double>& strains,
                             Warnings& warnings)
{
  if (largest.empty()) return;
  const double most = *std::max_element(strains.begin(), strains.end());
  std::vector<std::string> slack;
  for (const auto& [name, strain] : largest) {
    if (strain < slack_strain) slack.push_back(name + " (" + short_decimal(strain, 3) + ")");
  }
  const std::string remedy =
      "; their slack lengths are probably too long, or the pose of the meshes is not that of the table: "
      "reference_strain instead of slack_length_mm gives the strain at this pose";
  if (most < 0.0) {
    warnings.push_back("ligaments: every fibre is slack at the pose of the meshes, the largest strain is " +
                       short_decimal(most, 3) + remedy);
  } else if (!slack.empty()) {
    warnings.push_back("ligaments: slack at the pose of the meshes: " + join_alternatives(slack, " and ") +
                       ", by the largest strain of their fibres; wanted at least " +
                       shortest_decimal(slack_strain) + remedy);
  }
}

// Per unit strain (schemas/ligaments.md): the bundles of published knees have 1500 to 5700 N and the
// stiffest tendon 35,000 N. In N/mm a bundle has 40 to 250; times its length again, 45,000 and more.
constexpr double least_bundle_n = 300.0, most_bundle_n = 25000.0, most_tendon_n = 60000.0;
// In one bundle; published fibres of a bundle are equally stiff.
constexpr double most_uneven = 5.0;

double largest_of_bundle_n(const std::string& bundle)
{
  const bool is_named =
      std::ranges::find(model::knee_ligaments, model::ligament_of(bundle)) != std::end(model::knee_ligaments);
  return is_named ? most_bundle_n : most_tendon_n;
}

// The sums of the bundles; that of an uneven bundle is decided by the fibre that is warned of.
void warn_of_bundle_stiffness(const LoadedLigaments& loaded, const std::string& uneven_bundle,
                              Warnings& warnings)
{
  std::map<std::string, double> sum_n;
  for (const model::Fibre& fibre : loaded.ligaments.fibres) sum_n[fibre.bundle] += fibre.stiffness_n;
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const model::Fibre& fibre = loaded.ligaments.fibres[i];
    const double all_n = sum_n[fibre.bundle], most_n = largest_of_bundle_n(fibre.bundle);
    const bool is_soft = all_n < least_bundle_n;
    if (!fibre.bundle.empty() && fibre.bundle == uneven_bundle) continue;
    if (!is_soft && (all_n <= most_n || fibre.bundle.empty())) continue;
    std::string remedy = "most " + shortest_decimal(most_n) +
                         "; values that are in N already are not multiplied by a length: stiffness_n = " +
                         short_decimal(fibre.stiffness_n / fibre.slack_length_mm, 0);
    if (is_soft) {
      const bool is_per_mm = all_n * fibre.slack_length_mm >= least_bundle_n;
      const double stiffness_n = fibre.stiffness_n * (is_per_mm ? fibre.slack_length_mm : 1000.0);
      remedy = "least " + shortest_decimal(least_bundle_n) + "; " +
               (is_per_mm ? "N/mm times the slack length in mm" : "kN times 1000") +
               " gives N: stiffness_n = " + short_decimal(stiffness_n, 0);
    }
    warnings.push_back(place_of(loaded.jobs[i], "stiffness_n") + "and its bundle have " +
                       short_decimal(all_n, 1) + " N per unit strain, wanted at " + remedy);
    return;
  }
}

double median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

// Returns the bundle that it warns of, or an empty name.
std::string warn_of_uneven_bundles(const LoadedLigaments& loaded, Warnings& warnings)
{
  std::map<std::string, std::vector<double>> of_bundle;
  for (const model::Fibre& fibre : loaded.ligaments.fibres)
    of_bundle[fibre.bundle].push_back(fibre.stiffness_n);
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const model::Fibre& fibre = loaded.ligaments.fibres[i];
    const std::vector<double>& all = of_bundle[fibre.bundle];
    if (fibre.bundle.empty() || all.size() < 2) continue;
    // Of two fibres the other one.
    const double usual_n = all.size() == 2 ? all[0] + all[1] - fibre.stiffness_n : median(all);
    const double ratio = fibre.stiffness_n / usual_n;
    if (ratio <= most_uneven && ratio >= 1.0 / most_uneven) continue;
    warnings.push_back(place_of(loaded.jobs[i], "stiffness_n") + "has " +
                       short_decimal(fibre.stiffness_n, 1) + " N per unit strain, the other fibres of \"" +
                       fibre.bundle + "\" have " + short_decimal(usual_n, 1) + "; wanted at most " +
                       shortest_decimal(most_uneven) + " times less or more: N/mm times the slack length " +
                       "in mm gives N");
    return fibre.bundle;
  }
  return "";
}

}  // namespace

std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Case& job_case)
{
  Warnings warnings;
  if (loaded.jobs.empty()) return warnings;
  for (const End& end : {End{"reference_mm", &model::Fibre::reference_mm, &job_case.reference},
                         End{"moving_mm", &model::Fibre::moving_mm, &job_case.moving}}) {
    warn_of_far_attachments(loaded, end, job_case.joint, warnings);
    warn_of_scattered_bundles(loaded, end, warnings);
  }
  const std::vector<double> strains = strains_of(loaded);
  warn_of_strains(loaded, strains, warnings);
  if (job_case.joint == "knee" && job_case.method == "equilibrium") {
    const std::map<std::string, double> found = largest_strains(loaded, strains);
    warn_of_missing_ligaments(found, warnings);
    warn_of_missing_bundles(loaded, warnings);
    warn_of_slack_ligaments(found, strains, warnings);
  }
  warn_of_bundle_stiffness(loaded, warn_of_uneven_bundles(loaded, warnings), warnings);
  return warnings;
}

std::vector<std::string> bone_crossing_warnings(const Case& job_case)
{
  constexpr double allowed_mm = 2.0;
  const model::Ligaments& ligaments = job_case.ligaments;
  if (ligaments.fibres.empty()) return {};
  const geometry::BonesOfJoint bones{geometry::bone_of(job_case.reference),
                                     geometry::bone_of(job_case.moving)};
  const std::array at_meshes{Pose(Pose::Identity())};
  int n_inside = 0;
  std::string deepest_name;
  geometry::FibreCrossing deepest;
  for (const model::Fibre& fibre : ligaments.fibres) {
    const geometry::FibreCrossing crossing =
        geometry::deepest_crossing(bones, fibre, ligaments.wraps, at_meshes);
    if (crossing.depth_mm > allowed_mm) ++n_inside;
    if (crossing.depth_mm <= deepest.depth_mm) continue;
    deepest = crossing;
    deepest_name = fibre.name;
  }
  if (n_inside == 0) return {};
  const std::string& bone =
      deepest.body == BodyIndex::moving ? job_case.moving.name : job_case.reference.name;
  return {"fibre \"" + deepest_name + "\" is " + short_decimal(deepest.depth_mm, 1) +
          " mm inside the bone of \"" + bone + "\" at the pose of the meshes, wanted at most " +
          shortest_decimal(allowed_mm) + "; fibres as deep: " + std::to_string(n_inside) +
          "; wrap = \"...\" of a surface in ligaments.wraps leads a fibre over bone"};
}

namespace {

constexpr double least_collateral_mm = 15.0;  // those of real knees are 30 to 45 mm from the middle

// Mean z of the attachments of each ligament.
std::map<std::string, double> mean_z_mm(const Case& job_case)
{
  std::map<std::string, std::pair<double, double>> sums;  // of z at both ends, and their number
  for (const model::Fibre& fibre : job_case.ligaments.fibres) {
    auto& [sum_mm, n] = sums[model::ligament_of(fibre.bundle)];
    sum_mm += fibre.reference_mm.z() + fibre.moving_mm.z();
    n += 2.0;
  }
  std::map<std::string, double> means;
  for (const auto& [name, sum] : sums) means[name] = sum.first / sum.second;
  return means;
}

double middle_z_mm(const Case& job_case)
{
  const Box box = bounding_box(job_case.moving.contact.mesh);
  return 0.5 * (box.min_mm.z() + box.max_mm.z());
}

}  // namespace

std::optional<Side> collateral_side(const Case& job_case)
{
  std::map<std::string, double> z_mm = mean_z_mm(job_case);
  const double middle_mm = middle_z_mm(job_case);
  const bool has_medial = z_mm.contains("MCL"), has_lateral = z_mm.contains("LCL");
  if (job_case.joint != "knee" || (!has_medial && !has_lateral)) return std::nullopt;
  const double medial_mm = has_medial ? z_mm["MCL"] : middle_mm;
  const double lateral_mm = has_lateral ? z_mm["LCL"] : middle_mm;
  if (std::abs(lateral_mm - medial_mm) < least_collateral_mm) return std::nullopt;
  return lateral_mm > medial_mm ? Side::right : Side::left;
}

std::string misplaced_collateral(const Case& job_case, Side side)
{
  std::map<std::string, double> z_mm = mean_z_mm(job_case);
  if (job_case.joint != "knee" || !z_mm.contains("MCL") || !z_mm.contains("LCL")) return "";
  const double middle_mm = middle_z_mm(job_case);
  const double medial_mm = z_mm["MCL"] - middle_mm, lateral_mm = z_mm["LCL"] - middle_mm;
  if (medial_mm * lateral_mm < 0.0 ||
      std::min(std::abs(medial_mm), std::abs(lateral_mm)) < least_collateral_mm)
    return "";
  return (lateral_mm > 0.0) == (side == Side::right) ? "MCL" : "LCL";
}

}  // namespace vrda::job
