/// [laxity] of a job: the loads of `vrda laxity`; and a job over other flexions with free varus.
#pragma once

#include <optional>

#include "load/job.hpp"

namespace vrda::load {

/// Absent if the job has none. Throws InputError naming the key: angles that do not ascend, no load.
std::optional<LaxityJob> laxity_of(const documents::Document& document);

/// The job over these flexions (degrees, ascending) with varus free and nothing smoothed, whatever its grid.
/// Its texts are those of the given job. Throws InputError naming the key unless the method is the
/// equilibrium, Delta is +Y and turns with the moving object, and the job has a grid.
Job over_flexions(const Job& job, const std::vector<double>& flexion_deg);

}  // namespace vrda::load
