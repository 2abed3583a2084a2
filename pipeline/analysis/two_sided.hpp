/// The motion over flexion alone in which both compartments are in contact (thesis 5.4, 6.2.2).
#pragma once

#include <optional>

#include "store/motion_model.hpp"

namespace vrda::analysis {

struct TwoSidedOptions {
  int degree = 6;          ///< of the polynomials of x, z and theta; lowered to what the raw poses determine
  bool is_robust = false;  ///< Huber weights
  double spacing_deg = 0.25;  ///< largest step of the flexion axis, which contains the model's flexions
};

/// Smooths x, z, theta and varus of the raw course over flexion, then finds at each flexion the varus at
/// which the gaps of both compartments are equal, and the position along Delta at which the nearer one is
/// closed, up to contact_margin_mm (audit/pose_meter.hpp).
///  - Raw course: with the equilibrium the spine with free varus, which does not depend on the varus axis;
///  with the
///    stability search the zero-varus poses of the raw cells.
///  - Where the raw equilibrium lifts a compartment off by more than the contact resolution, the difference
///  of the
///    gaps is kept, linear between the raw flexions.
///  - A flexion has no pose beyond the raw course, and where no varus within 8 degrees of the smooth one
///  closes both
///    gaps.
/// Empty for a sequence of frames, if the joint has no compartments or the raw course has no pose. Bitwise
/// equal for any number of threads.
std::optional<store::TwoSided> two_sided(const store::MotionModel& model, const TwoSidedOptions& options,
                                         int n_threads);

}  // namespace vrda::analysis
