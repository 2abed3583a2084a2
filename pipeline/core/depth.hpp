/// The limit on nested keys, lists and tables, before a parser sees the text.
#pragma once

#include <string>
#include <string_view>

namespace vrda::inline core {

enum class Syntax { toml, json };

/// Throws InputError naming file, line and depth if the text has more than 40 levels: each part of a dotted
/// key or header, each list and each table is one. Time linear in the text.
void require_shallow(std::string_view text, const std::string& file, Syntax syntax);

/// The same for an override "key=value", whose file is "--set".
void require_shallow_override(std::string_view key, std::string_view value);

}  // namespace vrda::inline core
