/// A process that gives up what it does not need.
#pragma once

#include <string>

namespace vrda {

/// From now on this process can compute, take memory, read and write the files that are open, and end; the
/// kernel refuses every other system call with EPERM (seccomp): it opens no file or socket and starts no
/// program or thread. Returns why the kernel took no such filter; empty: it did. Under address and thread
/// sanitizers, whose reports need to open files, nothing is given up.
std::string confine_this_process();

}  // namespace vrda
