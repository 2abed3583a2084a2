/// The solver's input, both objects in the solver frame S at zero attitude with their search trees, and the
/// measurements at a final pose, common to all methods.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/contacts.hpp"
#include "model/mesh.hpp"
#include "model/step_record.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::solve {

/// A mesh in S and the component of each triangle (empty: one component).
struct SolverBody {
  Mesh mesh;
  std::vector<std::int32_t> component;
};

struct Joint {
  contact::Collider reference;
  contact::Collider moving;
  std::vector<Compartment> compartment_of_triangle;  ///< [n_moving_triangles], empty without compartments
  geometry::GapTree reference_gap;                  ///< the same objects, prepared for gap queries
  geometry::GapTree moving_gap;
  geometry::GapTree medial_gap;  ///< moving triangles of the compartment
  geometry::GapTree lateral_gap;
  std::vector<bool> reference_protrudes;  ///< [n_vertices] convex: can touch a face first
  std::vector<bool> moving_protrudes;
  double substep_mm = 0.0;  ///< upper bound of one motion of any vertex: half the thinnest part
};

/// `compartment_of_triangle` is empty or has one entry per moving triangle. Neither mesh may be empty.
Joint make_joint(const SolverBody& reference, const SolverBody& moving,
                 const std::vector<Compartment>& compartment_of_triangle);

/// Height of the bounding box: the extent along Delta in S.
double extent_along_delta_mm(const Mesh& mesh);

/// Thickness of the thinnest component: twice volume over area if closed, else its mean edge length.
double thinnest_part_mm(const SolverBody& body);

/// Joint::substep_mm of two bodies.
double substep_mm(const SolverBody& reference, const SolverBody& moving);

/// The record of a contact; its compartment is that of the moving triangle.
ContactRecord contact_record(const Joint& joint, const contact::Contact& contact);

/// Fills contacts, condyle flags and theta_determined of `record` from the contacts at its pose. Rotation is
/// determined when at least two contacts resist a turn about their mean point with a moment arm above
/// `resolution_mm`.
void measure_contacts(const Joint& joint, const std::vector<contact::Contact>& contacts, double resolution_mm,
                      StepRecord& record);

/// Fills the gap that each compartment has left along Delta at the pose; nothing without compartments. Adds
/// its queries to the record.
void measure_gaps(const Joint& joint, const Attitude& attitude, const MovingPose& pose, StepRecord& record);

}  // namespace vrda::solve
