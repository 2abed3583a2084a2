/// Values as a TOML file holds them.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace vrda {

/// In quotes, with escapes.
std::string quoted_text(std::string_view text);

/// "[1.5, 2.0]"; a number always has a point or an exponent, so that it reads back as one.
std::string number_text(double value);
std::string list_text(std::span<const double> values);

/// The fewest digits that read as `value` rounded to that many decimals, at most 9.
std::string rounded_text(double value, int decimals);

}  // namespace vrda
