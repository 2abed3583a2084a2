/// A file that appears whole or not at all.
#pragma once

#include <string>
#include <string_view>

namespace vrda {

/// Writes the HDF5 `content` and its seal (seal.hpp) under a temporary name in the same folder, waits for the
/// disk and renames, so that `path` holds the old file or the new one. Throws InputError naming `path` and
/// the system's reason; what was written of the new one is gone then.
void write_whole(const std::string& path, std::string_view content);

}  // namespace vrda
