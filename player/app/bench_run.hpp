/// The modes `bench` and `devices`.
#pragma once

#include "app/bench_options.hpp"
#include "app/show.hpp"

namespace vrda {

/// Drives the bench from its devices, or from a recording. Throws InputError for everything a user can put
/// right before it runs; while it runs a device that fails is shown as such and never ends it.
void run_bench(const BenchOptions& options, const ShowStreams& streams);

/// Lists the devices: whether each answers, its rate, its last values. Returns how many do not answer.
int list_devices(const DevicesOptions& options, const ShowStreams& streams);

}  // namespace vrda
