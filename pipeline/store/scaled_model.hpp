/// A motion model of a joint that is an even factor larger.
#pragma once

#include "store/motion_model.hpp"

namespace vrda {

/// Every length, energy and moment times `factor`, which is above 0, about the origin of the canonical axes;
/// angles, forces, strains, counts and the job's record as they are. Contact alone has no length of its own
/// (schemas/scaling.md): such a model is what a run at that scale would find, but for where its origin lies.
MotionModel scaled_model(MotionModel model, double factor);

}  // namespace vrda
