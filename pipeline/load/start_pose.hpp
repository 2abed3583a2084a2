/// The start of a joint whose job gives none.
#pragma once

#include <Eigen/Core>

#include "load/case.hpp"

namespace vrda::load {

/// Travel of the moving object from the pose of the meshes along Delta there to 0.1 mm before
/// the next contact ahead; if the meshes overlap, from the first pose back against Delta without overlap.
/// Zero if nothing is ahead. Attitude zero, theta of `loaded.initial`. Needs the meshes. Cost: a few queries.
double start_travel_mm(const Case& loaded);

}  // namespace vrda::load
