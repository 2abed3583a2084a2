/// A smoothed motion brought back into contact.
#pragma once

#include "store/motion_model.hpp"

namespace vrda {

/// Travel along Delta (mm, negative: back) from the smoothed pose of `set` into contact, at each attitude of
/// the model's grid: at all of them, also where no raw pose was found, since polynomials have a pose
/// everywhere. Rule: the contact that the pose itself would meet if it were let go. Free: on to the next
/// touch. Overlapping: back by 0.1, 0.2, 0.4 mm ... until free, on from there to the next touch. Stops
/// contact_margin_mm short of it, so that nothing overlaps. NaN where nothing is in the way. Same bits for
/// any number of threads. `set` need not be one of the model's, and what it holds of recontact_mm plays no
/// part.
GridD recontact(const MotionModel& model, const SmoothedSet& set, int n_threads);

}  // namespace vrda
