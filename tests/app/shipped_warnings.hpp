/// The warnings of the jobs in jobs/: each has a row with its reason, any other one fails a test.
#pragma once

#include <string>
#include <vector>

#include "support/process.hpp"

namespace vrda::test {

/// Path of a job relative to jobs/, without ".toml".
std::vector<std::string> shipped_jobs();

/// Expects that `vrda COMMAND` (run or check) of the job printed exactly the warnings of its rows.
void expect_known_warnings(const std::string& job, const std::string& command, const Ended& ended);

}  // namespace vrda::test
