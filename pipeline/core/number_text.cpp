#include "core/number_text.hpp"

#include <array>
#include <charconv>

namespace vrda {

std::string shortest(double value)
{
  std::array<char, 32> digits{};
  const std::to_chars_result end = std::to_chars(digits.data(), digits.data() + digits.size(), value + 0.0);
  return {digits.data(), end.ptr};
}

}  // namespace vrda
