/// A recording of the bench, shown again.
#pragma once

#include <string>

#include "app/bench_options.hpp"
#include "app/show.hpp"
#include "bench/timing.hpp"

namespace vrda {

/// Shows the recording `options.replay`. Throws InputError for everything a user can put right.
void replay_bench(const BenchOptions& options, const ShowStreams& streams);

/// Throws InputError naming `path` where it cannot be written.
void write_timing_file(const std::string& path, const BenchTiming& timing);

}  // namespace vrda
