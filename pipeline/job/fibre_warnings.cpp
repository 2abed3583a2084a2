// Warnings about implausible ligament fibres at the pose of the meshes.
#include "job/case_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/text.hpp"

namespace vrda::job {
namespace {

constexpr double infinity_mm = std::numeric_limits<double>::infinity();

double to_segment_mm(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  const Eigen::Vector3d along = b - a;
  const double share = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (a + share * along - p).norm();
}

double to_triangle_mm(const Eigen::Vector3d& p, const Mesh& mesh, Eigen::Index t)
{
  const auto [a, b, c] = corners(mesh, t);
  const Eigen::Vector3d normal = face_normal(mesh, t);
  const bool is_above = (b - a).cross(p - a).dot(normal) >= 0.0 && (c - b).cross(p - b).dot(normal) >= 0.0 &&
                        (a - c).cross(p - c).dot(normal) >= 0.0;
  if (is_above) return std::abs((p - a).dot(normal));
  return std::min({to_segment_mm(p, a, b), to_segment_mm(p, b, c), to_segment_mm(p, c, a)});
}

// Exact if above `enough_mm`, otherwise an upper bound below it: most attachments are near a vertex.
double to_surface_mm(const Eigen::Vector3d& p, const Mesh& mesh, double enough_mm)
{
  if (mesh.vertices_mm.rows() == 0) return infinity_mm;
  const double to_vertex_mm =
      std::sqrt((mesh.vertices_mm.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff());
  if (to_vertex_mm <= enough_mm) return to_vertex_mm;
  double least_mm = to_vertex_mm;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    least_mm = std::min(least_mm, to_triangle_mm(p, mesh, t));
  return least_mm;
}

// Fibres of real knees attach up to 14 mm from tibia and femur (fibular attachments without a fibula mesh)
// and up to 25 mm from cartilage without bone meshes.
double farthest_attachment_mm(const Body& body)
{
  const bool has_bone = std::any_of(body.components.begin(), body.components.end(),
                                    [](const Component& c) { return c.material == "bone"; });
  return has_bone ? 20.0 : 30.0;
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

void warn_of_far_attachments(const LoadedLigaments& loaded, const End& end,
                             std::vector<std::string>& warnings)
{
  const double enough_mm = farthest_attachment_mm(*end.body);
  std::size_t first = 0, n_far = 0;
  double first_mm = 0.0;
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const Eigen::Vector3d& p_mm = loaded.ligaments.fibres[i].*end.place_mm;
    const double off_mm = std::min(to_surface_mm(p_mm, end.body->contact.mesh, enough_mm),
                                   to_surface_mm(p_mm, end.body->visual.mesh, enough_mm));
    if (off_mm <= enough_mm) continue;
    if (n_far++ > 0) continue;
    first = i;
    first_mm = off_mm;
  }
  if (n_far == 0) return;
  warnings.push_back(place_of(loaded.jobs[first], end.key) + "attached " + rounded_text(first_mm, 10.0) +
                     " mm from the surface of " + end.body->name + and_more(n_far) +
                     "; attachments are in mm along the mesh files' axes, at most " +
                     shortest_decimal(enough_mm) + " mm from it");
}

void warn_of_scattered_bundles(const LoadedLigaments& loaded, const End& end,
                               std::vector<std::string>& warnings)
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
    warnings.push_back(place_of(loaded.jobs[i], end.key) + "attached " + rounded_text(nearest_mm, 10.0) +
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
    return strain > 0.0 ? "; its length there is " + rounded_text(length_mm, 10.0) +
                              " mm, so slack_length_mm = " + rounded_text(length_mm / 1.03, 10.0) +
                              " for a strain of 0.03"
                        : "; its length there is " + rounded_text(length_mm, 10.0) + " mm";
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

void warn_of_strains(const LoadedLigaments& loaded, const std::vector<double>& strains,
                     std::vector<std::string>& warnings)
{
  std::size_t first = 0, n_implausible = 0;
  for (std::size_t i = 0; i < strains.size(); ++i) {
    if (strains[i] >= least_strain && strains[i] <= largest_strain) continue;
    if (n_implausible++ == 0) first = i;
  }
  if (n_implausible == 0) return;
  const FibreJob& fibre = loaded.jobs[first];
  warnings.push_back(place_of(fibre, fibre.reference_strain ? "reference_strain" : "slack_length_mm") +
                     "has a strain of " + rounded_text(strains[first], 1000.0) +
                     " at the pose of the meshes" + and_more(n_implausible) + "; ligaments have " +
                     shortest_decimal(least_strain) + " to " + shortest_decimal(largest_strain) +
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

std::string joined_names(const std::vector<std::string>& names)
{
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

void warn_of_missing_ligaments(const std::map<std::string, double>& found, std::vector<std::string>& warnings)
{
  std::vector<std::string> missing;
  for (const char* name : model::knee_ligaments) {
    if (!found.contains(name)) missing.emplace_back(name);
  }
  if (found.empty() || missing.empty()) return;
  warnings.push_back("ligaments: no bundle is named " + joined_names(missing) +
                     ": the knee is solved as if it were cut; add its fibres, or leave it out on purpose");
}

// The bundles of divided ligaments of which another bundle is there. A ligament with a bundle of another name
// is divided otherwise. The posterior MCL of some published tables is part of the capsule ("pMC").
void warn_of_missing_bundles(const LoadedLigaments& loaded, std::vector<std::string>& warnings)
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
  warnings.push_back("ligaments: no bundle is named " + joined_names(missing) +
                     ", but others of the same ligament are there: the knee is solved as if it were cut; add "
                     "its fibres, or leave it out on purpose");
}

// Of published knees, each ligament has a fibre with a strain of at least -0.03 at the reference pose
// (schemas/ligaments.md). A table whose slack lengths are 1.2 times too long has -0.12 at most.
constexpr double slack_strain = -0.08;

void warn_of_slack_ligaments(const std::map<std::string, double>& largest, const std::vector<double>& strains,
                             std::vector<std::string>& warnings)
{
  if (largest.empty()) return;
  const double most = *std::max_element(strains.begin(), strains.end());
  std::vector<std::string> slack;
  for (const auto& [name, strain] : largest) {
    if (strain < slack_strain) slack.push_back(name + " (" + rounded_text(strain, 1000.0) + ")");
  }
  const std::string remedy =
      "; their slack lengths are probably too long, or the pose of the meshes is not that of the table: "
      "reference_strain instead of slack_length_mm gives the strain at this pose";
  if (most < 0.0) {
    warnings.push_back("ligaments: every fibre is slack at the pose of the meshes, the largest strain is " +
                       rounded_text(most, 1000.0) + remedy);
  } else if (!slack.empty()) {
    warnings.push_back("ligaments: slack at the pose of the meshes: " + joined_names(slack) +
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
  const bool is_named = std::ranges::find(model::knee_ligaments, model::ligament_of(bundle)) !=
                        std::end(model::knee_ligaments);
  return is_named ? most_bundle_n : most_tendon_n;
}

// The sums of the bundles; that of an uneven bundle is decided by the fibre that is warned of.
void warn_of_bundle_stiffness(const LoadedLigaments& loaded, const std::string& uneven_bundle,
                              std::vector<std::string>& warnings)
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
                         rounded_text(fibre.stiffness_n / fibre.slack_length_mm, 1.0);
    if (is_soft) {
      const bool is_per_mm = all_n * fibre.slack_length_mm >= least_bundle_n;
      const double stiffness_n = fibre.stiffness_n * (is_per_mm ? fibre.slack_length_mm : 1000.0);
      remedy = "least " + shortest_decimal(least_bundle_n) + "; " +
               (is_per_mm ? "N/mm times the slack length in mm" : "kN times 1000") +
               " gives N: stiffness_n = " + rounded_text(stiffness_n, 1.0);
    }
    warnings.push_back(place_of(loaded.jobs[i], "stiffness_n") + "and its bundle have " +
                       rounded_text(all_n, 10.0) + " N per unit strain, wanted at " + remedy);
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
std::string warn_of_uneven_bundles(const LoadedLigaments& loaded, std::vector<std::string>& warnings)
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
                       rounded_text(fibre.stiffness_n, 10.0) + " N per unit strain, the other fibres of \"" +
                       fibre.bundle + "\" have " + rounded_text(usual_n, 10.0) + "; wanted at most " +
                       shortest_decimal(most_uneven) + " times less or more: N/mm times the slack length " +
                       "in mm gives N");
    return fibre.bundle;
  }
  return "";
}

}  // namespace

std::string rounded_text(double value, double steps_per_unit)
{
  return shortest_decimal(std::round(value * steps_per_unit) / steps_per_unit + 0.0);
}

std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Case& job_case)
{
  std::vector<std::string> warnings;
  if (loaded.jobs.empty()) return warnings;
  for (const End& end : {End{"reference_mm", &model::Fibre::reference_mm, &job_case.reference},
                         End{"moving_mm", &model::Fibre::moving_mm, &job_case.moving}}) {
    warn_of_far_attachments(loaded, end, warnings);
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
