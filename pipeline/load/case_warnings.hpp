/// What loading can notice about a job that runs and may still not be meant.
#pragma once

#include "load/job.hpp"

namespace vrda {

/// One sentence each, in a fixed order: settings, then components. anatomy_warnings and fibre_warnings have
/// the rest.
std::vector<std::string> case_warnings(const Job& job, const Case& loaded);

}  // namespace vrda
