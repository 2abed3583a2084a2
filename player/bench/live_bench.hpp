/// The tracked joint as messages for browsers (schemas/live.md). In: motion model, bench file, calibration.
/// Out: one JSON text per moment, complete in itself. Device failures are marks in the messages.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "bench/bench_run.hpp"
#include "bench/bench_state.hpp"

namespace vrda::bench {

class LiveBench {
 public:
  /// Uses file, bench, calibration and set of the options, and connects to the devices. Throws InputError.
  explicit LiveBench(const BenchOptions& options);
  ~LiveBench();

  /// What stays the same: title, set, scale, points to touch.
  std::string greeting() const;
  /// Processes all samples that have arrived; never waits.
  std::string next();
  double interval_s() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The message of a frame. `error_message`: of the tracker's link; may be empty.
std::string live_message(const BenchFrame& frame, std::uint64_t number, const std::string& error_message);

}  // namespace vrda::bench
