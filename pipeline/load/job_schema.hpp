/// schemas/job.schema.json at work: which keys there are, what may stand there, what stands there by default.
#pragma once

#include "load/job_value.hpp"

namespace vrda {

/// The job with every default filled in, keys in the schema's order, numbers as the schema types them.
/// [campaign] is checked and left out. Throws InputError for an unknown key (naming the nearest known one), a
/// missing key, a wrong type or value, and for a campaign without a joint of its own.
JobValue checked_job(const JobDocument& document);

/// Whether there is a campaign and no joint: a list of jobs.
bool is_campaign_alone(const JobValue& root);

/// Checks the [campaign] that the document has, and the names of the job's keys that its levels set. Throws
/// InputError like checked_job(); of a campaign without a joint also for any other key.
void check_campaign(const JobDocument& document);

}  // namespace vrda
