/// The one offset of some components that brings a measured motion into contact.
#pragma once

#include <vector>

#include "core/fields.hpp"
#include "job/case.hpp"

namespace vrda::analysis {

/// The components whose offset is unknown, and the frames that determine it.
struct OffsetFitInput {
  std::vector<std::int32_t> reference, moving;  ///< indices into Body::components
  std::vector<Pose> X_reference_moving;         ///< measured, as in a motion model
};

enum class FitStatus {
  converged,
  at_limit,      ///< the best offset is 0 or the largest that a job may have
  undetermined,  ///< fewer than two frames have a gap that depends on the offset
  iteration_limit,
  not_smooth,  ///< no step of the smallest size lowers the misfit: equilibria jump
};
inline constexpr Named<FitStatus> fit_status_names[] = {{FitStatus::converged, "converged"},
                                                        {FitStatus::at_limit, "at_limit"},
                                                        {FitStatus::undetermined, "undetermined"},
                                                        {FitStatus::iteration_limit, "iteration_limit"},
                                                        {FitStatus::not_smooth, "not_smooth"}};
constexpr const auto& names_of(FitStatus)
{
  return fit_status_names;
}

struct OffsetFit {
  FitStatus status = FitStatus::undetermined;
  double offset_mm = 0.0;
  /// Of the offset, from the remaining gaps along their normals, taken as independent.
  double standard_error_mm = nan;
  double gap_rms_mm = nan;       ///< gaps along Delta of the frames at `offset_mm`
  double bare_gap_rms_mm = nan;  ///< without offset, over the frames that have a gap then
  double travel_per_mm = nan;    ///< median change of a gap for 1 mm of offset
  int n_frames = 0;              ///< that have a gap which depends on the offset
};

/// The offset at which the frames touch on average: the mean over the frames of their signed gaps along the
/// normal (the gap along Delta by its slope over the offset) is 0. Along Delta, one glancing contact would
/// outweigh all others. Newton's method with differences of the exact gap. `job_case` at the subject's size
/// with one Delta, or one that turns with the reference.
OffsetFit fit_offset(const job::Case& job_case, const OffsetFitInput& input);

/// Signed gaps of frames at an offset, mm; NaN where no facing surfaces are ahead.
std::vector<double> gaps_at_offset(const job::Case& job_case, const OffsetFitInput& input, double offset_mm);

}  // namespace vrda::analysis
