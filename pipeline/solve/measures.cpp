#include "solve/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "proximity/directional_gap.hpp"
#include "solve/prediction.hpp"

namespace vrda {
namespace {

double gap_or_nan_mm(const Joint& joint, const TreeMesh& reference, const BoxTree& compartment,
                     const MovingPose& pose)
{
  const Gap gap = directional_gap(reference, joint.moving.solid.mesh, compartment, pose);
  return std::isfinite(gap.travel_mm) ? gap.travel_mm : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

ContactRecord contact_record(const Joint& joint, const Contact& contact)
{
  ContactRecord kept{contact.point_mm,         contact.normal,
                     contact.distance_mm,      contact.triangles.reference,
                     contact.triangles.moving, 0};
  if (joint.compartment_of_triangle.empty()) return kept;
  kept.compartment = static_cast<std::int8_t>(
      joint.compartment_of_triangle[static_cast<std::size_t>(contact.triangles.moving)]);
  return kept;
}

void measure_contacts(const Joint& joint, const std::vector<Contact>& contacts, double resolution_mm,
                      StepRecord& record)
{
  const Eigen::Vector3d middle = mean_point(contacts);
  int n_resisting = 0;
  for (const Contact& c : contacts) {
    record.contacts.push_back(contact_record(joint, c));
    const auto compartment = static_cast<Compartment>(record.contacts.back().compartment);
    record.contact_medial = record.contact_medial || compartment == Compartment::medial;
    record.contact_lateral = record.contact_lateral || compartment == Compartment::lateral;
    n_resisting += std::abs(moment_about_mm(c, middle)) > resolution_mm ? 1 : 0;
  }
  record.theta_determined = n_resisting >= 2;
}

int measure_step(const Joint& joint, const TreeMesh& reference, const std::vector<Contact>& contacts,
                 double resolution_mm, StepRecord& record)
{
  measure_contacts(joint, contacts, resolution_mm, record);
  if (joint.compartment_of_triangle.empty()) return 0;
  record.gap_medial_mm = gap_or_nan_mm(joint, reference, joint.medial, record.pose);
  record.gap_lateral_mm = gap_or_nan_mm(joint, reference, joint.lateral, record.pose);
  return 2;
}

}  // namespace vrda
