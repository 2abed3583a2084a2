/// A sample motion model with everything that is made of its surfaces.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// `model` with a robust set and its recontact, a zero-varus motion and audits of all of them. The
/// zero-varus motion has a pose wherever the first column is solved: at even flexions both compartments
/// touch, at odd ones the varus is interpolated (or free everywhere, with a fifth smoothed surface, where
/// the model has one column); the first flexion with a successor turns too little for an axis. The audits
/// have every state.
MotionModel with_derived(MotionModel model);

/// A model with every dataset but the fifth smoothed surface: an equilibrium with five fibres and two wraps,
/// scaled by landmarks, and what is derived of it.
MotionModel whole_model();

}  // namespace vrda::test
