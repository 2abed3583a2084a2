/// Assigns the triangles of the moving object to compartments.
#pragma once

#include "load/job.hpp"

namespace vrda::load {

/// [n_triangles of moving.contact]; empty if the job has no compartments. Compartments given by component
/// names are assigned first; then one given by a half-space takes the remaining triangles with their centroid
/// on that side of the rotation centre (canonical z). All others are `none`. Throws InputError for a name
/// that is not a moving contact component or is in both compartments.
std::vector<Compartment> compartments_of(const Job& job, const Body& moving, double centre_z_mm);

}  // namespace vrda::load
