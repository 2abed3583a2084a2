/// A file that appears whole or not at all.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace vrda {

/// Writes the pieces, one after the other, under a temporary name in the same folder, waits for the disk and
/// renames, so that `path` holds the old file or the new one. Throws InputError naming `path` and the
/// system's reason; what was written of the new one is gone then.
void write_whole(const std::string& path, std::initializer_list<std::string_view> pieces);

}  // namespace vrda
