/// Warnings about valid jobs that are probably not intended.
#pragma once

#include "load/job.hpp"

namespace vrda::load {

/// One sentence each, in a fixed order: settings, then components. See also anatomy_warnings, fibre_warnings.
std::vector<std::string> case_warnings(const Job& job, const Case& loaded);

}  // namespace vrda::load
