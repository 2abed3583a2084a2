/// Where this program stands, for those it starts.
#pragma once

#include <string>

namespace vrda {

/// Path by which another process starts this program: links resolved, or, when a carried loader runs it
/// (scripts/with_glibc), the launcher's. Empty where /proc does not tell.
std::string own_program();

/// The same of an executable by /proc and of the name that the program was called by.
std::string program_to_start(const std::string& executable, const std::string& called_by);

}  // namespace vrda
