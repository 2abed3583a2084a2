/// What a misspelt name may have meant, and which there are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vrda {

/// Fewest insertions, deletions and replacements that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `known` nearest to `word`, the earlier of two; empty when there is none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "a, b or c".
std::string alternatives(const std::vector<std::string>& words);

}  // namespace vrda
