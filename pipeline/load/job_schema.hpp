/// Jobs and campaigns against their schemas (documents/schema.hpp).
#pragma once

#include "documents/document.hpp"

namespace vrda {

/// The job with every default filled in, keys in the schema's order, numbers as the schema types them.
/// [campaign] is checked and left out. Throws InputError for an unknown key (naming the nearest known one), a
/// missing key, a wrong type or value, and for a campaign without a joint of its own.
DocumentValue checked_job(const Document& document);

/// Whether there is a campaign and no joint: a list of jobs.
bool is_campaign_alone(const DocumentValue& root);

/// Checks the [campaign] that the document has, and the names of the job's keys that its levels set. Throws
/// InputError like checked_job(); of a campaign without a joint also for any other key.
void check_campaign(const Document& document);

}  // namespace vrda
