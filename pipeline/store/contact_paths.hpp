/// Centre of contact of each compartment, from the contacts or the contact forces of a motion model.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::store {

/// For each stable cell and compartment: the mean of the points of its contact forces, weighted by force
/// magnitude; without an equilibrium the unweighted mean of its contacts. NaN without contacts.
/// `model` must have poses, varus_solved_deg, push.delta, contacts and equilibrium->forces.
ContactPaths contact_paths_of(const MotionModel& model);

}  // namespace vrda::store
