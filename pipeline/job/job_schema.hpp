/// Validation of jobs and campaigns against their schemas (documents/schema.hpp).
#pragma once

#include "core/document.hpp"

namespace vrda::job {

/// The job with defaults filled in, keys in the order of the schema and numbers typed by the schema.
/// [campaign] is checked and removed. Throws InputError for an unknown key (naming the nearest known one), a
/// missing key, a wrong type or value, and for a campaign without a joint.
core::DocumentValue checked_job(const core::Document& document);

/// Whether the document has a campaign and no joint, so it is a list of jobs.
bool is_campaign_only(const core::DocumentValue& root);

/// Checks the [campaign] of the document and the job keys that its levels set. Throws InputError like
/// checked_job(), and for any other key next to a campaign without a joint.
void check_campaign(const core::Document& document);

}  // namespace vrda::job
