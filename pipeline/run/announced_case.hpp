/// What solving commands begin with.
#pragma once

#include <string>

#include "load/case.hpp"

namespace vrda {

/// load_case(), with its warnings said, and how it is scaled.
Case announced_case(const std::string& job_file, const LoadOptions& options);

}  // namespace vrda
