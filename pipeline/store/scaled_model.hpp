/// Uniform scaling of a motion model to a subject's size, without a new run.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::store {

/// Multiplies every length, energy and moment by `factor` (above 0) about the origin of the canonical axes.
/// Angles, forces, strains, counts and the job record are unchanged. Pure contact has no length scale
/// (schemas/scaling.md): the result equals a run at that scale, up to the position of the origin.
MotionModel scaled_model(MotionModel model, double factor);

}  // namespace vrda::store
