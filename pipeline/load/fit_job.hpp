/// [fit] of a job: what `vrda fit --to` may change.
#pragma once

#include <optional>

#include "load/job.hpp"

namespace vrda::load {

/// Absent if the job has none. Throws InputError naming the key: one that the quantity does not have or
/// lacks, angles that do not ascend, no coordinate to fit.
std::optional<FitJob> fit_of(const documents::Document& document);

}  // namespace vrda::load
