#include "core/utf8.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vrda {
namespace {

/// The smallest character that needs this many bytes after the first.
constexpr std::array<std::uint32_t, 4> smallest{0, 0x80, 0x800, 0x10000};

/// Bytes that follow `first`; 4 where it begins no character.
std::size_t n_following(unsigned char first)
{
  if (first < 0x80) return 0;
  if (first >= 0xc0 && first < 0xe0) return 1;
  if (first >= 0xe0 && first < 0xf0) return 2;
  return first >= 0xf0 && first < 0xf8 ? 3 : 4;
}

}  // namespace

bool is_utf8(std::string_view bytes)
{
  for (std::size_t at = 0; at < bytes.size();) {
    const auto first = static_cast<unsigned char>(bytes[at++]);
    const std::size_t n = n_following(first);
    if (n == 0) continue;
    if (n > 3 || bytes.size() - at < n) return false;
    std::uint32_t character = first & (0x3fu >> n);
    for (std::size_t k = 0; k < n; ++k, ++at) {
      const auto next = static_cast<unsigned char>(bytes[at]);
      if ((next & 0xc0u) != 0x80u) return false;
      character = character << 6 | (next & 0x3fu);
    }
    const bool is_surrogate = character >= 0xd800 && character <= 0xdfff;
    if (character < smallest[n] || character > 0x10ffff || is_surrogate) return false;
  }
  return true;
}

}  // namespace vrda
