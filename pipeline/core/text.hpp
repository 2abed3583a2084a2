/// Text from outside, numbers as text, and what a misspelt name may have meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vrda {

/// Whether the bytes are UTF-8 (RFC 3629): no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view bytes);

/// Whether a control character stands in the text (UTF-8) that is none of `allowed`: those of ASCII and of
/// Latin-1 (U+0080 to U+009F), which steer a terminal.
bool has_control_characters(std::string_view text, std::string_view allowed = {});

/// The same text with each byte of a control character as "\\x1b": one line that steers no terminal.
std::string printable(std::string_view text);

/// `value` in the fewest digits that read back as the same double; -0 as 0, so that equal numbers give equal
/// text.
std::string shortest(double value);

/// Fewest insertions, deletions and replacements that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `known` nearest to `word`, the earlier of two; empty when there is none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "a, b or c".
std::string alternatives(const std::vector<std::string>& words);

}  // namespace vrda
