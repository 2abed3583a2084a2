#include "web/token.hpp"

#include <sys/random.h>

#include <array>

#include "core/error.hpp"

namespace vrda {

std::string random_token()
{
  std::array<unsigned char, 16> bytes{};
  check(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()),
        "the kernel gives random bytes");
  constexpr const char* digits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) {
    token += digits[byte >> 4U];
    token += digits[byte & 15U];
  }
  return token;
}

bool is_same_token(std::string_view given, std::string_view token)
{
  if (given.size() != token.size()) return false;
  int difference = 0;
  for (std::size_t k = 0; k < token.size(); ++k) difference |= given[k] ^ token[k];
  return difference == 0;
}

}  // namespace vrda
