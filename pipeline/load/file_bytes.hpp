/// Reads whole files with a size limit, and computes SHA-256.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace vrda::load {

/// The content of `file`. Throws InputError for a missing file, a folder, an unreadable file and one larger
/// than `largest_bytes`; `facts` supplies file, field and wanted of the message.
std::string file_bytes(const std::string& file, const InputError::Facts& facts, std::uintmax_t largest_bytes);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256_of(std::string_view bytes);

}  // namespace vrda::load
