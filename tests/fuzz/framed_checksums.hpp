// Repairs checksums of framed files after a change, since changes detected by a checksum test little.
#pragma once

#include <zlib.h>

#include "core/framed_file.hpp"
#include "fuzz/outcome.hpp"

namespace vrda::test {

inline constexpr std::size_t fixed_header_bytes = 16;  // magic, version, length of the key

inline std::uint32_t crc_of(const std::uint8_t* data, std::size_t size, std::uint32_t before = 0)
{
  return static_cast<std::uint32_t>(crc32_z(before, data, size));
}

inline void put(std::uint8_t* at, std::uint32_t value)
{
  for (int k = 0; k < 4; ++k) at[k] = static_cast<std::uint8_t>(value >> (8 * k));
}

// Follows the lengths like the reader; stops where they exceed the data.
inline void repair_checksums(std::uint8_t* data, std::size_t size)
{
  const std::string bytes = text_of(data, size);
  if (size < fixed_header_bytes + 4) return;
  const std::size_t key_end = fixed_header_bytes + core::u32_at(bytes, fixed_header_bytes - 4);
  if (key_end + 4 > size) return;
  put(data + key_end, crc_of(data, key_end));
  for (std::size_t at = key_end + 4; at + core::frame_head_bytes <= size;) {
    const std::size_t length = core::u32_at(bytes, at);
    if (length > size - at - core::frame_head_bytes) return;
    put(data + at + 4, crc_of(data + at + core::frame_head_bytes, length, crc_of(data + at, 4)));
    at += core::frame_head_bytes + length;
  }
}

}  // namespace vrda::test
