// Warnings about implausible ligament fibres at the pose of the meshes.
#include "load/case_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/text.hpp"

namespace vrda::load {
namespace {

constexpr double infinity_mm = std::numeric_limits<double>::infinity();

std::string rounded_text(double value, double steps_per_unit)
{
  return shortest_decimal(std::round(value * steps_per_unit) / steps_per_unit);
}

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
  Eigen::Vector3d ligament::Fibre::*place_mm;
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
  const std::vector<ligament::Fibre>& fibres = loaded.ligaments.fibres;
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

void warn_of_strains(const LoadedLigaments& loaded, std::vector<std::string>& warnings)
{
  const std::vector<ligament::FibreState> states = ligament::fibre_states(loaded.ligaments, {}, {});
  std::size_t first = 0, n_implausible = 0;
  const auto strain_of = [&](std::size_t i) {
    return states[i].length_mm / loaded.ligaments.fibres[i].slack_length_mm - 1.0;
  };
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double strain = strain_of(i);
    if (strain >= least_strain && strain <= largest_strain) continue;
    if (n_implausible++ == 0) first = i;
  }
  if (n_implausible == 0) return;
  const FibreJob& fibre = loaded.jobs[first];
  warnings.push_back(place_of(fibre, fibre.reference_strain ? "reference_strain" : "slack_length_mm") +
                     "has a strain of " + rounded_text(strain_of(first), 1000.0) +
                     " at the pose of the meshes" + and_more(n_implausible) + "; ligaments have " +
                     shortest_decimal(least_strain) + " to " + shortest_decimal(largest_strain) +
                     strain_remedy(fibre, strain_of(first), states[first].length_mm));
}

// The softest bundle of the real knees has 1800 N per unit strain. Stiffnesses in N/mm are 50 to 200.
void warn_of_stiffnesses(const LoadedLigaments& loaded, std::vector<std::string>& warnings)
{
  constexpr double least_n = 300.0;
  std::map<std::string, double> sum_n;
  for (const ligament::Fibre& fibre : loaded.ligaments.fibres) sum_n[fibre.bundle] += fibre.stiffness_n;
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const ligament::Fibre& fibre = loaded.ligaments.fibres[i];
    if (sum_n[fibre.bundle] >= least_n) continue;
    warnings.push_back(place_of(loaded.jobs[i], "stiffness_n") + "and its bundle have " +
                       rounded_text(sum_n[fibre.bundle], 10.0) + " N per unit strain, wanted at least " +
                       shortest_decimal(least_n) + "; N/mm times the slack length in mm gives N: " +
                       "stiffness_n = " + rounded_text(fibre.stiffness_n * fibre.slack_length_mm, 1.0));
    return;
  }
}

}  // namespace

std::vector<std::string> fibre_warnings(const LoadedLigaments& loaded, const Body& reference,
                                        const Body& moving)
{
  std::vector<std::string> warnings;
  for (const End& end : {End{"reference_mm", &ligament::Fibre::reference_mm, &reference},
                         End{"moving_mm", &ligament::Fibre::moving_mm, &moving}}) {
    warn_of_far_attachments(loaded, end, warnings);
    warn_of_scattered_bundles(loaded, end, warnings);
  }
  warn_of_strains(loaded, warnings);
  warn_of_stiffnesses(loaded, warnings);
  return warnings;
}

}  // namespace vrda::load
