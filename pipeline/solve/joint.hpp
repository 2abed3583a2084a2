/// The solver's input, both objects in the solver frame S at zero attitude with their search trees, and the
/// measurements at a final pose, common to all methods.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/contacts.hpp"
#include "core/mesh.hpp"
#include "core/step_record.hpp"
#include "proximity/gap_query.hpp"

namespace vrda {

/// A mesh in S and the component of each triangle (empty: one component).
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
  GapTree reference_gap;  ///< the same objects, prepared for the gap queries of the equilibrium
  GapTree moving_gap;
  GapTree medial_gap;
  GapTree lateral_gap;
  std::vector<bool> reference_sticks_out;  ///< [n_vertices] convex: can touch a face first
  std::vector<bool> moving_sticks_out;
  double substep_mm = 0.0;  ///< upper bound of one motion of any vertex: half the thinnest part
};

/// `compartment_of_triangle` is empty or has one entry per moving triangle. Neither mesh may be empty.
Joint make_joint(const SolverBody& reference, const SolverBody& moving,
                 const std::vector<Compartment>& compartment_of_triangle);

/// Height of the bounding box: the extent along Delta in S.
double extent_along_delta_mm(const Mesh& mesh);

/// Thickness of the thinnest component: twice volume over area if closed, else its mean edge length.
double thinnest_mm(const SolverBody& body);

/// The record of a contact; its compartment is that of the moving triangle.
ContactRecord contact_record(const Joint& joint, const Contact& contact);

/// Fills contacts, condyle flags and theta_determined of `record` from the contacts at its pose. Rotation is
/// determined when at least two contacts resist a turn about their mean point with a moment arm above
/// `resolution_mm`.
void measure_contacts(const Joint& joint, const std::vector<Contact>& contacts, double resolution_mm,
                      StepRecord& record);

/// Like measure_contacts(), and fills the remaining gap of each compartment at `record.pose`. `reference` is
/// at the attitude; `contacts` are those of that pose. Returns the number of gap queries.
int measure_step(const Joint& joint, const TreeMesh& reference, const std::vector<Contact>& contacts,
                 double resolution_mm, StepRecord& record);

}  // namespace vrda
