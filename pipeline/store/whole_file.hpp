/// A file that appears whole or not at all.
#pragma once

#include <functional>
#include <string>

namespace vrda {

/// Lets `write` fill a temporary name in the same folder, seals it (seal.hpp), flushes it to the disk and
/// renames it, so that `path` holds the old file or the new one. Throws InputError naming `path` when it
/// cannot be written.
void write_whole(const std::string& path, const std::function<void(const std::string& temporary)>& write);

}  // namespace vrda
