/// `vrda index`: one table of the results of a submission.
#pragma once

#include <string>

#include "cluster/submission.hpp"
#include "talk/talk.hpp"

namespace vrda {

struct IndexOptions {
  std::string folder;  ///< of a submission
  bool as_json = false;
  int n_processes = 0;  ///< that read models; 0: as many as there are processors
};

/// Writes index.csv, index.h5 and index.times.csv there and prints their paths. Cases that are not done are
/// rows too. Throws InputError where there is no submission or no room.
ExitCode index_command(const IndexOptions& options);

/// The same of a submission that is read already, its folder absolute.
ExitCode write_index_of(const IndexOptions& options, const Submission& submission);

}  // namespace vrda
