/// The lock (`flock`) that tells that somebody writes a file.
#pragma once

#include <string>

namespace vrda {

/// Locks the open file; false while another process holds it. `path`: for the InputError where the file
/// system has no locks, which must not look like a lock that is held.
bool lock_without_waiting(int descriptor, const std::string& path);

}  // namespace vrda
