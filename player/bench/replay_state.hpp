/// The bench's state at any frame of a recording.
#pragma once

#include <optional>
#include <vector>

#include "bench/bench_run.hpp"
#include "bench/bench_state.hpp"
#include "bench/recording.hpp"

namespace vrda::bench {

/// Playing on gives the frames of the session, bit by bit. A jump replays the last `run_up` frames before the
/// target; of earlier frames it applies only what lasts: keys, board, pointer and links, and the last poses
/// of each tool. Clocks, filters and predictors have forgotten the rest by then.
class ReplayState {
 public:
  static constexpr std::size_t run_up = 7200;  ///< two minutes at 60 frames a second

  /// Both must outlive the state.
  ReplayState(const BenchSetup& setup, bench::RecordingReader& recording);
  /// Frame `n`.
  const BenchFrame& at(std::size_t n);
  BenchState& state() { return *state_; }

 private:
  void begin();
  void skip_to(std::size_t n);
  void take_next();

  const BenchSetup& setup_;
  bench::RecordingReader& recording_;
  std::optional<BenchState> state_;
  const BenchFrame* frame_ = nullptr;
  std::size_t n_taken_ = 0;
};

}  // namespace vrda::bench
