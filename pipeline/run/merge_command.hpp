/// `vrda merge`: journals of shards -> motion model.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "talk/talk.hpp"

namespace vrda {

struct MergeOptions {
  std::vector<std::string> journals;  ///< empty: the spine's and all shards' beside the output
  std::string output;
  std::string job_file;  ///< empty: what the case file beside the journals says, like the next two
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_threads = 0;  ///< for smoothing; 0: as many as there are processors
  bool keeps_journals = false;
  bool may_replace = false;   ///< the result of another job
  std::int32_t n_shards = 0;  ///< known: their journals are looked for by name, too; 0: not known
};

/// The same bytes as a run in one piece. Throws InputError naming the attitudes and shards that are missing;
/// the journals stay then, and when interrupted. An output that holds this result already is left as it is.
ExitCode merge_command(const MergeOptions& options);

}  // namespace vrda
