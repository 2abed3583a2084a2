/// `vrda merge`: journals of shards -> motion model.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/console.hpp"

namespace vrda::run {

struct MergeOptions {
  std::vector<std::string> journals;  ///< empty: those of the spine and all shards next to the output
  std::string output;
  std::string job_file;  ///< empty: from the case file next to the journals, like the next two
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_threads = 0;  ///< for smoothing; 0: one per processor
  bool keeps_journals = false;
  bool may_replace = false;   ///< replaces the result of another job
  std::int32_t n_shards = 0;  ///< if known: their journals are also opened by name; 0: unknown
};

/// Gives the same bytes as a single run. Throws InputError with the missing attitudes and shards. Then, and
/// when interrupted, the journals are kept. An output that already contains this result is not changed.
core::ExitCode merge_command(const MergeOptions& options);

}  // namespace vrda::run
