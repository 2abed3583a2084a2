/// [scaling] of a job: scales a case to the subject's size by a factor or a landmark table.
/// schemas/scaling.md defines what is scaled and when the steps are kept.
#pragma once

#include "job/component_loader.hpp"

namespace vrda::job {

/// The requested scaling; empty members if the job has no [scaling] or no landmarks.
struct RequestedScaling {
  std::optional<Scaling> scaling;
  std::vector<LoadedInput> inputs;
  std::vector<std::string> warnings;  ///< a poor fit of the landmarks
};

/// Reads the landmark table if the job names one (data folder first) and fits the factor.
/// Throws InputError naming the key of the job or the table; also for a factor outside 0.1 to 10.
RequestedScaling load_scaling(const Job& job, const std::string& data_directory, const AxisMap& map);

/// Applies `requested` to a case at factor 1 and sets `steps_job_text`. If a uniform factor keeps the steps,
/// `loaded` stays at factor 1 and `steps_scale` is set for the results; otherwise its lengths are scaled and
/// `rerun_reason` gives the reason. Throws InputError for a non-uniform factor with a wrapping surface or
/// with a fibre whose attachments coincide.
void apply_scaling(Case& loaded, const Job& job, const RequestedScaling& requested);

}  // namespace vrda::job
