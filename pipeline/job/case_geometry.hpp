/// Parts of a case that follow from its meshes: compartments and the start of the motion.
#pragma once

#include <Eigen/Core>

#include "job/case.hpp"
#include "job/job.hpp"

namespace vrda::job {

/// The compartment of each triangle, [n_triangles of moving.contact]; empty if the job has no compartments.
/// Compartments given by component names are assigned first; then one given by a half-space takes the
/// remaining triangles with their centroid on that side of the rotation centre (canonical z). All others are
/// `none`. Throws InputError for a name that is not a moving contact component or is in both compartments.
std::vector<Compartment> compartments_of(const Job& job, const Body& moving, double centre_z_mm);

/// The start of a joint whose job gives none: travel of the moving object from the pose of the meshes along
/// Delta there to 0.1 mm before the next contact ahead; if the meshes overlap, from the first pose back
/// against Delta without overlap. Zero if nothing is ahead. Attitude zero, theta of `loaded.initial`. Needs
/// the meshes. Cost: a few queries.
double start_travel_mm(const Case& loaded);

}  // namespace vrda::job
