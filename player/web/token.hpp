/// The secret in the page's address: whoever does not know it is not served.
#pragma once

#include <string>
#include <string_view>

namespace vrda {

/// 128 bits of the kernel's random source as 32 hexadecimal digits.
std::string random_token();

/// Takes as long for any text of the token's length, so that nobody finds the token digit by digit.
bool is_same_token(std::string_view given, std::string_view token);

}  // namespace vrda
