/// Validation of jobs and campaigns against their schemas (documents/schema.hpp).
#pragma once

#include "documents/document.hpp"

namespace vrda::load {

/// The job with defaults filled in, keys in the order of the schema and numbers typed by the schema.
/// [campaign] is checked and removed. Throws InputError for an unknown key (naming the nearest known one), a
/// missing key, a wrong type or value, and for a campaign without a joint.
documents::DocumentValue checked_job(const documents::Document& document);

/// Whether the document has a campaign and no joint, so it is a list of jobs.
bool is_campaign_only(const documents::DocumentValue& root);

/// Checks the [campaign] of the document and the job keys that its levels set. Throws InputError like
/// checked_job(), and for any other key next to a campaign without a joint.
void check_campaign(const documents::Document& document);

}  // namespace vrda::load
