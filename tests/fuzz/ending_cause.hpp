/// Cause of a crash from the report of the sanitizer.
#pragma once

#include <string>

namespace vrda::test {

/// Writes sanitizer reports of forked children to files, so that they do not count as a crash. Call once.
void report_copies();

/// The children's reports since the last call.
std::string take_reports();

/// "libhdf5 SEGV", or "VRDA ..." if the cause is not in HDF5.
std::string cause_in(const std::string& report);

}  // namespace vrda::test
