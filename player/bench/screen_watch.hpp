/// Window or memory of the bench, and a check that the window has the calibrated position and size.
#pragma once

#include <optional>
#include <string>

#include "core/error.hpp"
#include "loop/sink.hpp"
#include "setup/bench_file.hpp"

namespace vrda {

/// Window of the frame buffer's size, at the bench file's position if given; without vertical
/// synchronisation, because the loop paces the frames. Throws InputError without a display.
Sink bench_window(const BenchFile& bench, const std::string& title, int samples);
Sink bench_memory(const BenchFile& bench, int samples);

/// Differences of the window from the bench file, which invalidate the calibration; empty: none.
std::optional<InputError::Facts> misplaced(const BenchFile& bench, const std::optional<WindowPlace>& place);

/// Checks the window periodically.
class ScreenWatch {
 public:
  explicit ScreenWatch(const BenchFile& bench) : bench_(bench) {}

  /// Message for the panel; empty: the window is correct. Allocates only on a change.
  const std::string& trouble(const Sink& sink);
  /// The same for the log, returned once.
  std::string take_warning();

 private:
  const BenchFile& bench_;
  int n_calls_ = 0;
  bool was_warned_ = false;
  std::string trouble_, warning_;
};

}  // namespace vrda
