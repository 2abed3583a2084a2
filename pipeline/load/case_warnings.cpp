#include "load/case_warnings.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/number_text.hpp"
#include "load/condyles.hpp"

namespace vrda {
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
                       " times its resolution; below ten times, the search has little room to halve it");
  };
  compare("translation", job.search.translation_step_mm, job.search.translation_resolution_mm);
  compare("rotation", job.search.rotation_step_rad, job.search.rotation_resolution_rad);
}

// Whether the job file or an override names the key, or one below it. `root` is the file's tree, without
// defaults.
bool is_given(const Job& job, const JobValue& root, const std::string& key)
{
  for (const std::string& given : job.document.overridden) {
    if (given == key || given.starts_with(key + ".")) return true;
  }
  const JobValue* value = &root;
  for (std::size_t from = 0; value != nullptr && from <= key.size();) {
    const std::size_t dot = std::min(key.find('.', from), key.size());
    value = value->find(std::string_view(key).substr(from, dot - from));
    from = dot + 1;
  }
  return value != nullptr;
}

// What one method reads and the other does not.
void warn_of_other_method(const Job& job, const JobValue& root, Warnings& warnings)
{
  const auto warn = [&](const std::string& key, const char* why) {
    if (is_given(job, root, key)) warnings.push_back(key + ": it has no effect on " + why);
  };
  if (job.method == SolverMethod::equilibrium) {
    for (const char* key :
         {"approach_step_mm", "translation_step_mm", "translation_resolution_mm", "rotation_step_deg",
          "rotation_resolution_deg", "points", "normals", "max_steps"}) {
      warn(std::string("solver.search.") + key, "the equilibrium, which takes no steps");
    }
    return;
  }
  if (job.ligaments) {
    warnings.push_back("ligaments: they have no effect on the stability search, which knows contact only");
  }
  for (const char* key : {"push.force_n", "push.lateral_force_n", "push.moment_nmm", "push.varus_moment_nmm",
                          "push.point_mm", "solver.equilibrium"}) {
    warn(key, "the stability search, which knows directions of forces only");
  }
}

void warn_of_unused(const Job& job, Warnings& warnings)
{
  const JobValue root = parse_toml(job.text, job.file);
  warn_of_other_method(job, root, warnings);
  const std::size_t n_flexion = job.grid.flexion_deg.size(), n_varus = job.grid.varus_deg.size();
  for (const std::int32_t degree : job.smooth_degrees) {
    // An axis of one angle takes no part: only the constant is used of it.
    const std::size_t n_angles = n_varus == 1     ? n_flexion
                                 : n_flexion == 1 ? n_varus
                                                  : std::min(n_flexion, n_varus);
    if (static_cast<std::size_t>(degree) < n_angles) continue;
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
  if (component.n_boundary_edges > 0) {
    // Of a sheet of n triangles some sqrt(n) edges are boundary; a torn closed surface has fewer.
    const bool is_torn = component.n_boundary_edges * component.n_boundary_edges < component.n_triangles;
    warnings.push_back(
        named(component) +
        (is_torn ? ": nearly closed, with small holes (boundary edges: "
                 : ": an open sheet, which is fine (boundary edges: ") +
        std::to_string(component.n_boundary_edges) +
        "); its outside is where its triangles are wound to, or the opposite with winding = \"inward\"");
  }
  if (component.n_non_manifold_edges > 0) {
    warnings.push_back(named(component) +
                       ": edges with more than two faces, or with faces wound against each other: " +
                       std::to_string(component.n_non_manifold_edges));
  }
}

double diagonal_mm(const Box& box)
{
  return (box.max_mm - box.min_mm).norm();
}

// The unit that would make a component of this size one of a joint's usual size.
std::string likelier_unit(const std::string& unit, double size_mm, double least_mm, double most_mm)
{
  struct Unit {
    const char* word;
    double mm;
  };
  constexpr Unit units[] = {{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}};
  const Unit* read =
      std::find_if(std::begin(units), std::end(units), [&](const Unit& u) { return unit == u.word; });
  for (const Unit& other : units) {
    const double size_then_mm = size_mm / read->mm * other.mm;
    if (size_then_mm >= least_mm && size_then_mm <= most_mm) return other.word;
  }
  return "";
}

void warn_of_size(const Job& job, const ComponentSurvey& component, Warnings& warnings)
{
  // A knee's menisci are 40 mm long, a whole tibia 450 mm; other joints go from a finger's to a hip's bones.
  const double least_mm = job.joint == "knee" ? 12.0 : 3.0;
  const double most_mm = job.joint == "knee" ? 800.0 : 2000.0;
  const double size_mm = diagonal_mm(component.box);
  if (size_mm >= least_mm && size_mm <= most_mm) return;
  std::string text = named(component) + ": its bounding box measures " +
                     shortest(std::round(size_mm * 1000.0) / 1000.0) + " mm across";
  if (const std::string unit = likelier_unit(job.frame.unit, size_mm, least_mm, most_mm); !unit.empty()) {
    text += "; frame.unit says \"" + job.frame.unit + "\", the size suggests \"" + unit + "\"";
  }
  warnings.push_back(text);
}

bool mentions(const std::string& name, const char* word)
{
  std::string lower = name;
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower.find(word) != std::string::npos;
}

double middle_z_mm(const ComponentSurvey& component)
{
  return 0.5 * (component.box.min_mm.z() + component.box.max_mm.z());
}

// Mean z of the components whose name says one side; nothing when none does.
std::optional<double> mean_z_mm(const std::vector<ComponentSurvey>& survey, const char* word,
                                const char* also)
{
  double sum = 0.0;
  int n = 0;
  for (const ComponentSurvey& component : survey) {
    if (!mentions(component.name, word) && !mentions(component.name, also)) continue;
    sum += middle_z_mm(component);
    ++n;
  }
  return n == 0 ? std::nullopt : std::optional<double>(sum / n);
}

// Lateral lies to the right on a right knee; the fibula is lateral too.
void warn_of_side(const Job& job, const Case& loaded, Warnings& warnings)
{
  const std::optional<double> medial_mm = mean_z_mm(loaded.survey, "medial", "medial");
  const std::optional<double> lateral_mm = mean_z_mm(loaded.survey, "lateral", "fibula");
  if (!medial_mm && !lateral_mm) return;
  const double centre_mm = loaded.frame.rotation_centre_mm.z();
  const double to_the_right_mm = lateral_mm.value_or(centre_mm) - medial_mm.value_or(centre_mm);
  const bool looks_right = to_the_right_mm > 0.0;
  if (to_the_right_mm == 0.0 || looks_right == (job.side == Side::right)) return;
  warnings.push_back(std::string("side: the job says ") + (job.side == Side::right ? "right" : "left") +
                     ", but the components named lateral lie to the " + (looks_right ? "right" : "left") +
                     " of those named medial, as in a " + (looks_right ? "right" : "left") + " knee");
}

void warn_of_centre(const Case& loaded, Warnings& warnings)
{
  constexpr double farthest_mm = 30.0;  // DESIGN.md 3
  const std::optional<CondyleSpheres> spheres = condyle_spheres(loaded.reference.contact.mesh);
  if (!spheres) return;
  const Eigen::Vector3d middle_mm = 0.5 * (spheres->left.centre_mm + spheres->right.centre_mm);
  const double distance_mm = (loaded.frame.rotation_centre_mm - middle_mm).norm();
  if (distance_mm <= farthest_mm) return;
  warnings.push_back("frame.origin: the rotation centre lies " + one_decimal(distance_mm) +
                     " mm from the middle of the condyles, (" + one_decimal(middle_mm.x()) + ", " +
                     one_decimal(middle_mm.y()) + ", " + one_decimal(middle_mm.z()) +
                     ") mm in canonical axes");
}

}  // namespace

std::vector<std::string> case_warnings(const Job& job, const Case& loaded)
{
  Warnings warnings;
  if (job.has_campaign) {
    warnings.emplace_back(
        "campaign: this is the job itself, without the campaign, which is for vrda plan and vrda submit");
  }
  if (job.method == SolverMethod::stability_search) warn_of_steps(job, warnings);
  warn_of_unused(job, warnings);
  for (const ComponentSurvey& component : loaded.survey) {
    warn_of_edges(component, warnings);
    warn_of_size(job, component, warnings);
  }
  if (job.joint != "knee") return warnings;
  warn_of_side(job, loaded, warnings);
  warn_of_centre(loaded, warnings);
  return warnings;
}

}  // namespace vrda
