/// What loading can notice about a job that runs and may still not be meant.
#pragma once

#include "load/job.hpp"

namespace vrda {

/// One sentence each, in a fixed order: settings first, then components, then the joint as a whole.
std::vector<std::string> case_warnings(const Job& job, const Case& loaded);

}  // namespace vrda
