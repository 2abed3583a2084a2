/// Where each compartment bears its load, from the contacts or the contact forces of a motion model.
#pragma once

#include "store/motion_model.hpp"

namespace vrda {

/// The paths that `model` implies: of each stable cell and compartment the mean of its contact forces'
/// points, weighted by their size; without an equilibrium the plain mean of its contacts. NaN where there are
/// none. Uses poses, varus_solved_deg, push.delta, contacts and equilibrium->forces, which must be filled in.
ContactPaths contact_paths_of(const MotionModel& model);

}  // namespace vrda
