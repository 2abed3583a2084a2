/// `vrda index`: the table of a campaign's results.
#pragma once

#include <string>

#include "app/talk.hpp"
#include "cluster/submission.hpp"

namespace vrda {

/// Writes index.csv, index.h5 and index.times.csv into the submission's folder, a row a case, whatever became
/// of it; prints the first one's path.
ExitCode index_command(const std::string& folder);

/// The same of a submission that is read already.
ExitCode write_index_of(const std::string& folder, const Submission& submission);

}  // namespace vrda
