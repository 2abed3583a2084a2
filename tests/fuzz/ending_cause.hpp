/// Processes forked by a fuzz target: coverage shared with them, and the cause of a crash.
#pragma once

#include <string>

namespace vrda::test {

/// Writes sanitizer reports of forked children to files, so that they do not count as a crash. Call once.
void report_copies();

/// The children's reports since the last call.
std::string take_reports();

/// "libhdf5 SEGV", or "VRDA ..." if the cause is not in HDF5.
std::string cause_in(const std::string& report);

/// From now on this process and its children count in shared memory. Exits on failure.
void share_coverage();

}  // namespace vrda::test
