#include "solve/joint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/features.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "geometry/gap_query.hpp"
#include "solve/stability_search.hpp"

namespace vrda::solve {
double extent_along_delta_mm(const Mesh& mesh)
{
  const Box box = bounding_box(mesh);
  return box.max_mm.y() - box.min_mm.y();
}

double thinnest_part_mm(const SolverBody& body)
{
  const std::int32_t n_components =
      body.component.empty() ? 1 : 1 + *std::max_element(body.component.begin(), body.component.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t c = 0; c < n_components; ++c) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index t = 0; t < body.mesh.triangles.rows(); ++t) {
      if (body.component.empty() || body.component[static_cast<std::size_t>(t)] == c) rows.push_back(t);
    }
    if (rows.empty()) continue;
    const Mesh part = select_triangles(body.mesh, rows);
    const bool is_closed = edge_counts(part).boundary == 0;
    least = std::min(least, is_closed ? 2.0 * std::abs(signed_volume_mm3(part)) / area_mm2(part)
                                      : mean_edge_length_mm(part));
  }
  return least;
}

double substep_mm(const SolverBody& reference, const SolverBody& moving)
{
  return 0.5 * std::min(thinnest_part_mm(reference), thinnest_part_mm(moving));
}

Joint make_joint(const SolverBody& reference, const SolverBody& moving,
                 const std::vector<Compartment>& compartment_of_triangle)
{
  check(reference.mesh.triangles.rows() > 0 && moving.mesh.triangles.rows() > 0, "make_joint: an empty mesh");
  check(compartment_of_triangle.empty() ||
            static_cast<Eigen::Index>(compartment_of_triangle.size()) == moving.mesh.triangles.rows(),
        "make_joint: one compartment per moving triangle");
  Joint joint;
  joint.reference = contact::make_collider(reference.mesh);
  joint.moving = contact::make_collider(moving.mesh);
  joint.compartment_of_triangle = compartment_of_triangle;
  const std::vector<std::int32_t> medial = triangles_of(compartment_of_triangle, Compartment::medial);
  const std::vector<std::int32_t> lateral = triangles_of(compartment_of_triangle, Compartment::lateral);
  joint.reference_gap = geometry::GapTree(reference.mesh);
  joint.moving_gap = geometry::GapTree(moving.mesh);
  joint.medial_gap = geometry::GapTree(moving.mesh, medial);
  joint.lateral_gap = geometry::GapTree(moving.mesh, lateral);
  joint.reference_protrudes =
      contact::protruding_vertices(joint.reference.tree_mesh.mesh, joint.reference.features);
  joint.moving_protrudes = contact::protruding_vertices(joint.moving.tree_mesh.mesh, joint.moving.features);
  joint.substep_mm = substep_mm(reference, moving);
  return joint;
}

ContactRecord contact_record(const Joint& joint, const contact::Contact& contact)
{
  ContactRecord record{contact.point_mm,         contact.normal,
                       contact.distance_mm,      contact.triangles.reference,
                       contact.triangles.moving, 0};
  if (joint.compartment_of_triangle.empty()) return record;
  record.compartment = static_cast<std::int8_t>(
      joint.compartment_of_triangle[static_cast<std::size_t>(contact.triangles.moving)]);
  return record;
}

void measure_contacts(const Joint& joint, const std::vector<contact::Contact>& contacts, double resolution_mm,
                      StepRecord& record)
{
  const Eigen::Vector3d middle = mean_point(contacts);
  int n_resisting = 0;
  for (const contact::Contact& c : contacts) {
    record.contacts.push_back(contact_record(joint, c));
    const auto compartment = static_cast<Compartment>(record.contacts.back().compartment);
    record.contact_medial = record.contact_medial || compartment == Compartment::medial;
    record.contact_lateral = record.contact_lateral || compartment == Compartment::lateral;
    n_resisting += std::abs(moment_about_mm(c, middle)) > resolution_mm ? 1 : 0;
  }
  record.theta_determined = n_resisting >= 2;
}

void measure_gaps(const Joint& joint, const Attitude& attitude, const MovingPose& pose, StepRecord& record)
{
  if (joint.compartment_of_triangle.empty()) return;
  const auto gap_mm = [&](const geometry::GapTree& compartment) {
    geometry::GapQuery query(joint.reference_gap, compartment);
    query.set_attitude(attitude);
    ++record.queries;
    const double travel_mm = query.next_contact(pose).travel_mm;
    return std::isfinite(travel_mm) ? travel_mm : nan;
  };
  record.gap_medial_mm = gap_mm(joint.medial_gap);
  record.gap_lateral_mm = gap_mm(joint.lateral_gap);
}

}  // namespace vrda::solve
