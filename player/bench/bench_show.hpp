/// Shows the pictures of a bench, one after the other, wherever they go.
#pragma once

#include "bench/bench_run.hpp"
#include "bench/bench_setup.hpp"
#include "bench/bench_view.hpp"
#include "bench/screen_watch.hpp"
#include "recording/recording.hpp"

namespace vrda {

/// What pressed keys ask of the loop.
struct BenchWishes {
  bool quits = false, zeroes_stage = false, writes_calibration = false, takes_picture = false;
};

/// Keys first, then samples: the same for a live round and its record. Eyes that cannot be drawn for are put
/// back to what they were before, and the panel tells it. Without keys and words allocates nothing.
BenchWishes take(BenchState& state, PanelContent& panel, std::span<const KeyPress> keys,
                 std::span<const Sample> samples);

class BenchShow {
 public:
  BenchShow(const BenchOptions& options, const BenchSetup& setup);

  Sink& sink() { return sink_; }
  PanelContent& panel() { return panel_; }

  /// Draws picture `number` of the run; to files too where they are wanted.
  void show(BenchState& state, const BenchFrame& frame, std::uint64_t number);
  /// The last picture again, into a new file of the current folder.
  void save(BenchState& state, const BenchFrame& frame);
  /// Ends the film.
  void finish();
  /// Shown for some seconds.
  void tell(const std::string& message, double now_s);
  void forget_message(double now_s);
  /// Of a window that is not as the bench file has it, told once; else empty.
  std::string take_warning() { return watch_.take_warning(); }

 private:
  Frame drawn(BenchState& state, const BenchFrame& frame);

  const BenchOptions& options_;
  BenchView view_;
  Sink sink_;
  ScreenWatch watch_;
  PanelContent panel_;
  double message_until_s_ = 0.0;
};

}  // namespace vrda
