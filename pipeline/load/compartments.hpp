/// Which side of a joint each moving triangle belongs to.
#pragma once

#include "load/job.hpp"

namespace vrda {

/// [n_triangles of moving.contact]; empty when the job has no compartments. A compartment given by
/// component names takes those components' triangles, before one given by half-space takes those whose
/// centroid lies to the left or right of the rotation centre (canonical z). The rest is `none`.
/// Throws InputError for a name that is no moving component in contact, or that both claim.
std::vector<Compartment> compartments_of(const Job& job, const Body& moving, double centre_z_mm);

}  // namespace vrda
