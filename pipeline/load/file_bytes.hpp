/// Whole files in memory, bounded, and their SHA-256.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace vrda {

/// The content of `file`. Throws InputError for a missing file, a folder, one that cannot be read or is
/// larger than `largest_bytes`; its file, field and wanted come from `facts`.
std::string file_bytes(const std::string& file, const InputError::Facts& facts, std::uintmax_t largest_bytes);

/// SHA-256 in 64 lower-case hexadecimal digits.
std::string sha256_of(std::string_view bytes);

}  // namespace vrda
