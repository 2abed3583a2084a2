/// System call filter (seccomp) of the current process.
#pragma once

#include <string>

namespace vrda::store {

/// Restricts this process to computing, allocating memory, reading and writing open files, and exiting. The
/// kernel refuses every other system call with EPERM: no file, socket, program or thread can be opened or
/// started. Returns an empty string, or the reason why the kernel rejected the filter. Does nothing under
/// address and thread sanitizers, whose reports need to open files.
std::string confine_this_process();

}  // namespace vrda::store
