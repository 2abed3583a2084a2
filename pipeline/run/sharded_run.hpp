/// Parts of a run, each a process of its own: the spine, and shards of the rows.
#pragma once

#include "run/run_command.hpp"
#include "talk/talk.hpp"

namespace vrda {

/// Solves the spine into its own journal; nothing is left to do where that is complete.
ExitCode spine_command(const RunOptions& options);

/// Solves the rows of options.shard into the shard's journal. Reads the spine, or solves it where nobody else
/// does.
ExitCode shard_command(const RunOptions& options);

}  // namespace vrda
