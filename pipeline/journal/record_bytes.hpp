/// The content of one journal record, byte by byte.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/step_record.hpp"

namespace vrda {

/// Little-endian, least byte first.
void append_u32(std::string& bytes, std::uint32_t value);
std::uint32_t u32_at(std::string_view bytes, std::size_t offset);

std::string bytes_of(const StepRecord& record);

/// The inverse of bytes_of; nothing when the bytes are no record.
std::optional<StepRecord> record_of(std::string_view bytes);

}  // namespace vrda
