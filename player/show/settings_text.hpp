/// Formatting of TOML values for files that the player writes: the text reads back as the same value.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace vrda::show {

/// A quoted string with escapes.
std::string quoted_text(std::string_view text);

/// Numbers always have a decimal point or an exponent, so that TOML reads them as floats; a list is
/// "[1.5, 2.0]".
std::string number_text(double value);
std::string list_text(std::span<const double> values);

/// `value` rounded to `decimals` (at most 9), in the fewest digits.
std::string rounded_text(double value, int decimals);

}  // namespace vrda::show
