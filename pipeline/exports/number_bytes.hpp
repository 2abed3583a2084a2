/// Numbers as the bytes of binary files, little-endian.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

namespace vrda {

static_assert(std::endian::native == std::endian::little, "bytes are written as they lie in memory");

template <typename Number>
void put(std::string& bytes, Number value)
{
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace vrda
