/// schemas/job.schema.json at work: which keys there are, what may stand there, what stands there by default.
#pragma once

#include "load/job_value.hpp"

namespace vrda {

/// The job with every default filled in, keys in the schema's order, numbers as the schema types them.
/// Throws InputError for an unknown key (naming the nearest known one), a missing key, a wrong type or value.
JobValue checked_job(const JobDocument& document);

/// Fewest insertions, deletions and replacements that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `known` nearest to `word`, the earlier of two; empty when there is none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace vrda
