/// What a solver works on, both objects in the solver frame S at zero attitude, ready to be queried, and what
/// is measured at a final pose, whatever method found it.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/contacts.hpp"
#include "core/mesh.hpp"
#include "core/step_record.hpp"
#include "proximity/gap_query.hpp"

namespace vrda {

/// A mesh in S and the component each triangle belongs to (empty: one component).
struct SolverBody {
  Mesh mesh;
  std::vector<std::int32_t> component;
};

struct Joint {
  Collider reference;
  Collider moving;
  std::vector<Compartment> compartment_of_triangle;  ///< [n_moving_triangles], empty without compartments
  BoxTree medial;                                    ///< moving triangles of the compartment
  BoxTree lateral;
  GapTree reference_gap;  ///< the same objects, prepared for the equilibrium's queries
  GapTree moving_gap;
  GapTree medial_gap;
  GapTree lateral_gap;
  std::vector<bool> reference_sticks_out;  ///< [n_vertices] can touch a face first
  std::vector<bool> moving_sticks_out;
  double substep_mm = 0.0;  ///< no vertex may move further at once: half the thinnest part
};

/// `compartment_of_triangle` is empty or holds one entry a moving triangle. Neither mesh may be empty.
Joint make_joint(const SolverBody& reference, const SolverBody& moving,
                 const std::vector<Compartment>& compartment_of_triangle);

/// Height of the bounding box: the extent along Delta in S.
double extent_along_delta_mm(const Mesh& mesh);

/// Mean thickness of the thinnest component: twice volume over area of a closed one, the mean edge of an
/// open sheet.
double thinnest_mm(const SolverBody& body);

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
