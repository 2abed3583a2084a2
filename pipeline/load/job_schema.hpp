/// schemas/job.schema.json at work: which keys there are, what may stand there, what stands there by default.
#pragma once

#include "load/job_value.hpp"

namespace vrda {

/// The job with every default filled in, keys in the schema's order, numbers as the schema types them.
/// Throws InputError for an unknown key (naming the nearest known one), a missing key, a wrong type or value.
JobValue checked_job(const JobDocument& document);

}  // namespace vrda
