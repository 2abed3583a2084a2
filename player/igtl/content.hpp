/// Heads and bodies of single messages: what stream.hpp is made of.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "igtl/message.hpp"

namespace vrda {

constexpr std::size_t igtl_head_bytes = 58;

struct IgtlHead {
  int version = 0;
  std::string type;  ///< as it stands in the message
  std::string device;
  std::int64_t device_ns = 0;
  std::uint64_t body_bytes = 0, crc = 0;
};

/// Of igtl_head_bytes bytes; control characters of the names become '?'.
IgtlHead head_of(std::span<const std::uint8_t> bytes);

/// ECMA-182, going on from the checksum of what came before.
std::uint64_t igtl_crc(std::span<const std::uint8_t> bytes, std::uint64_t before = 0);

bool is_known_type(const std::string& type);

/// Nothing where the body's size or its meta data do not fit the type.
std::optional<IgtlMessage> message_of(const IgtlHead& head, std::span<const std::uint8_t> body);

/// The type's name on the line.
const char* type_of(IgtlKind kind);

}  // namespace vrda
