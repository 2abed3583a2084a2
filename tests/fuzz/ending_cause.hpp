/// What a process of ours died of, by the report of its sanitizer.
#pragma once

#include <string>

namespace vrda::test {

/// In copies of this process, reports go to files and are no crash of this one. Call once.
void report_copies();

/// All that the copies reported since the last call.
std::string take_reports();

/// "libhdf5 SEGV", or "our own ..." where HDF5 is not to blame.
std::string cause_in(const std::string& report);

}  // namespace vrda::test
