/// What is measured at a final pose, whatever method found it.
#pragma once

#include "core/step_record.hpp"
#include "solve/joint.hpp"

namespace vrda {

/// What is kept of a contact; its compartment is that of the moving triangle.
ContactRecord contact_record(const Joint& joint, const Contact& contact);

/// Fills contacts, condyle flags and theta_determined of `record` from the contacts of its pose. Rotation
/// counts as determined when two contacts at least resist a turn about their mean point with a lever of more
/// than `resolution_mm`.
void measure_contacts(const Joint& joint, const std::vector<Contact>& contacts, double resolution_mm,
                      StepRecord& record);

/// Fills contacts, condyle flags, gaps left in each compartment and theta_determined of `record` at
/// `record.pose`. `reference` is at the attitude; `contacts` are those of that pose. Returns the number
/// of gap queries.
int measure_step(const Joint& joint, const TreeMesh& reference, const std::vector<Contact>& contacts,
                 double resolution_mm, StepRecord& record);

}  // namespace vrda
