/// Window or memory of the bench, and a check that the window has the calibrated position and size.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/bench_file.hpp"
#include "core/text.hpp"
#include "show/loop.hpp"

namespace vrda::bench {

/// Window of the frame buffer's size, at the bench file's position or monitors if given; without vertical
/// synchronisation, because the loop paces the frames. Throws InputError without a display, or if a monitor
/// is missing or two monitors are not side by side.
show::Sink bench_window(const BenchFile& bench, const std::string& title, int samples);
/// The same without a window. `samples`: per pixel, 1, 2 or 4.
show::Sink bench_memory(const BenchFile& bench, int samples);

/// The position of the window by `display.at` or `display.outputs`; empty: placed by the desktop. Throws
/// InputError as bench_window().
std::optional<std::array<int, 2>> window_position(const BenchFile& bench,
                                                  std::span<const view::Monitor> monitors);

/// Differences of the window from the bench file, which invalidate the calibration, and parts of it that no
/// monitor displays; empty: none.
std::optional<InputError::Facts> window_mismatch(const BenchFile& bench,
                                                 const std::optional<view::WindowGeometry>& place,
                                                 std::span<const view::Monitor> monitors);

/// Checks the window periodically.
class WindowCheck {
 public:
  /// `bench` must outlive this object.
  explicit WindowCheck(const BenchFile& bench) : bench_(bench) {}

  /// Message for the panel; empty: the window is correct. Allocates only on a change.
  const std::string& error_message(const show::Sink& sink);
  /// The same for the log, returned once.
  std::string take_warning();

 private:
  const BenchFile& bench_;
  int n_calls_ = 0;
  bool was_warned_ = false;
  view::WindowGeometry place_;
  std::vector<view::Monitor> monitors_;
  std::string error_message_, warning_;
};

}  // namespace vrda::bench
