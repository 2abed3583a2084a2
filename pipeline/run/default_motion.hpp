/// Decides which motion of a model is its default: the smoothed one only if it meets the criteria of
/// `vrda compare`. Also measures the contact of smoothed motions for these criteria.
#pragma once

#include <string>
#include <vector>

#include "analysis/compare.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {

/// Measures the motion of a degree in contact: two-sided with compartments, else after recontact along Delta,
/// at and halfway between the attitudes of the grid.
analysis::MeasureContact contact_measure(int n_threads);

/// The first of store::set_names(model) if that is not smoothed, or if its degree has no fault in a
/// comparison of the model's degrees (of its smoothed sets and of its two-sided motion); otherwise "raw" with
/// the fault. The reason is that of compare/recommend.hpp. Bitwise equal for any number of threads. Cost: a
/// fit per degree and, but for the degree of the two-sided motion, moving it into contact.
store::DefaultMotion evaluated_default_motion(const store::MotionModel& model, bool is_robust, int n_threads);

/// "default motion: raw, the solved poses; two_sided (degree 4) does not meet ..."; for a model that was not
/// compared with a remark.
std::string default_motion_line(const store::MotionModel& model);

/// "screw-home along the spine: net ...": rotation of a knee along the spine (motion/curve_figures.hpp).
/// Empty for other joints.
std::string screw_home_line(const store::MotionModel& model);

/// The raw motion's jumps: of theta along the spine (motion/curve_figures.hpp), and of the pose if it is too
/// large for any polynomial and the default motion's reason does not name it. May be empty.
std::vector<std::string> jump_lines(const store::MotionModel& model);

}  // namespace vrda::run
