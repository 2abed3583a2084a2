/// What a solver works on: both objects in the solver frame S at zero attitude, ready to be queried.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/contacts.hpp"
#include "core/compartment.hpp"
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

}  // namespace vrda
