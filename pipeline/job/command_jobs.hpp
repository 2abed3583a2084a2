/// Tables of a job for single commands: [fit] and [laxity].
#pragma once

#include <optional>

#include "job/job.hpp"

namespace vrda::job {

/// [fit]: what `vrda fit --to` may change. Absent if the job has none. Throws InputError naming the key: one
/// that the quantity does not have or lacks, angles that do not ascend, no coordinate to fit.
std::optional<FitJob> fit_of(const core::Document& document);

/// [laxity]: the loads of `vrda laxity`. Absent if the job has none. Throws InputError naming the key: angles
/// that do not ascend, no load.
std::optional<LaxityJob> laxity_of(const core::Document& document);

/// The job over these flexions (degrees, ascending) with varus free and nothing smoothed, whatever its grid.
/// Its texts are those of the given job. Throws InputError naming the key unless the method is the
/// equilibrium, Delta is +Y and turns with the moving object, and the job has a grid.
Job over_flexions(const Job& job, const std::vector<double>& flexion_deg);

}  // namespace vrda::job
