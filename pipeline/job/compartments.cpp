// Assigns the triangles of the moving object to compartments.
#include "job/case_geometry.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/job_schema.hpp"

namespace vrda::job {
namespace {

std::vector<std::string> contact_names(const Body& moving)
{
  std::vector<std::string> names;
  for (std::size_t c = 0; c < moving.components.size(); ++c) {
    const auto& of_triangle = moving.contact.component;
    const bool has_triangles =
        std::find(of_triangle.begin(), of_triangle.end(), static_cast<std::int32_t>(c)) != of_triangle.end();
    if (has_triangles) names.push_back(moving.components[c].name);
  }
  return names;
}

using Assignment = std::vector<Compartment>;  // [n components] compartment of each, by name

Assignment with_named(Assignment assigned, const Job& job, const Body& moving, Compartment which)
{
  const bool is_medial = which == Compartment::medial;
  const std::string key = std::string("compartments.") + (is_medial ? "medial" : "lateral") + ".components";
  const std::vector<std::string> known = contact_names(moving);
  const auto refuse = [&](const std::string& found, const std::string& wanted) {
    throw InputError({job.document.source_of(key), key, found, wanted});
  };
  for (const std::string& name : (is_medial ? job.medial : job.lateral)->components) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      refuse("\"" + name + "\"",
             "a moving contact component; the nearest is \"" + nearest_word(name, known) + "\"");
    }
    std::size_t c = 0;
    while (moving.components[c].name != name) ++c;
    if (assigned[c] != Compartment::none)
      refuse("\"" + name + "\" a second time", "each component in one compartment");
    assigned[c] = which;
  }
  return assigned;
}

Assignment assigned_by_name(const Job& job, const Body& moving)
{
  const Assignment none(moving.components.size(), Compartment::none);
  return with_named(with_named(none, job, moving, Compartment::medial), job, moving, Compartment::lateral);
}

bool is_in(const std::string& half_space, double z_mm, double centre_z_mm)
{
  return (half_space == "left" && z_mm < centre_z_mm) || (half_space == "right" && z_mm > centre_z_mm);
}

}  // namespace

std::vector<Compartment> compartments_of(const Job& job, const Body& moving, double centre_z_mm)
{
  if (!job.medial || !job.lateral) return {};
  if (!job.medial->half_space.empty() && job.medial->half_space == job.lateral->half_space) {
    throw InputError({job.document.source_of("compartments"), "compartments",
                      "medial and lateral both \"" + job.medial->half_space + "\"", "one half-space each"});
  }
  const Assignment assigned = assigned_by_name(job, moving);
  const Mesh& mesh = moving.contact.mesh;
  std::vector<Compartment> out;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const double z_mm = (a.z() + b.z() + c.z()) / 3.0;
    Compartment compartment =
        assigned[static_cast<std::size_t>(moving.contact.component[static_cast<std::size_t>(t)])];
    if (compartment == Compartment::none && is_in(job.medial->half_space, z_mm, centre_z_mm))
      compartment = Compartment::medial;
    if (compartment == Compartment::none && is_in(job.lateral->half_space, z_mm, centre_z_mm))
      compartment = Compartment::lateral;
    out.push_back(compartment);
  }
  return out;
}

}  // namespace vrda::job
