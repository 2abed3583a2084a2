/// A comparison of degrees in words and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compare/compare.hpp"

namespace vrda {

/// A row a degree: lengths are of the translation as a vector, angles of each surface. Ends with a line feed.
std::string table_of(const Comparison& comparison);

/// The recommendation as a sentence.
std::string sentence_of(const Recommendation& recommendation);

/// Everything that is known of each degree; what is not a number is null.
nlohmann::ordered_json json_of(const Comparison& comparison);

}  // namespace vrda
