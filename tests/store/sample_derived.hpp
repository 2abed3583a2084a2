/// A sample motion model with all derived data.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// `model` with a robust set and its recontact, a zero-varus motion and audits of all of them. The
/// zero-varus motion has a pose wherever the first column is solved: at even flexions both compartments
/// are in contact, at odd ones the varus is interpolated (free everywhere, with a fifth smoothed surface, if
/// the model has one column); the first interval's rotation is too small for an axis. The audits have every
/// state.
store::MotionModel with_derived(store::MotionModel model);

/// A model with every dataset except the fifth smoothed surface: an equilibrium with five fibres and two
/// wraps, scaled by landmarks, with derived data.
store::MotionModel whole_model();

/// A sequence of frames with its audit.
store::MotionModel frames_model();

}  // namespace vrda::test
