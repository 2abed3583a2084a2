/// The motion over flexion of one sample of an uncertain job.
#pragma once

#include <optional>
#include <string>

#include "store/motion_model.hpp"

namespace vrda::motion {

/// The sample of a set of quantile_set_names(model), as a table over the model's flexions; `contact` is that of
/// no pose where it is not stable. Empty for other sets.
std::optional<store::TwoSided> quantile_motion(const store::MotionModel& model, const std::string& set);

}  // namespace vrda::motion
