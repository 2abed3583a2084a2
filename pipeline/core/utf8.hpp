/// Text from outside.
#pragma once

#include <string>
#include <string_view>

namespace vrda {

/// Whether the bytes are UTF-8 (RFC 3629): no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view bytes);

/// Whether a control character stands in the text (UTF-8) that is none of `allowed`: those of ASCII and of
/// Latin-1 (U+0080 to U+009F), which steer a terminal.
bool has_control_characters(std::string_view text, std::string_view allowed = {});

/// The same text with each byte of a control character as "\\x1b": one line that steers no terminal.
std::string printable(std::string_view text);

}  // namespace vrda
