/// Window or memory of the bench, and a check that the window has the calibrated position and size.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench_files/bench_file.hpp"
#include "core/error.hpp"
#include "loop/sink.hpp"

namespace vrda::bench {

/// Window of the frame buffer's size, at the bench file's position or monitors if given; without vertical
/// synchronisation, because the loop paces the frames. Throws InputError without a display, or if a monitor
/// is missing or two monitors are not side by side.
loop::Sink bench_window(const bench_files::BenchFile& bench, const std::string& title, int samples);
loop::Sink bench_memory(const bench_files::BenchFile& bench, int samples);

/// The position of the window by `display.at` or `display.outputs`; empty: placed by the desktop. Throws
/// InputError as bench_window().
std::optional<std::array<int, 2>> window_position(const bench_files::BenchFile& bench,
                                                  std::span<const render::Monitor> monitors);

/// Differences of the window from the bench file, which invalidate the calibration, and parts of it that no
/// monitor displays; empty: none.
std::optional<InputError::Facts> window_mismatch(const bench_files::BenchFile& bench,
                                                 const std::optional<render::WindowGeometry>& place,
                                                 std::span<const render::Monitor> monitors);

/// Checks the window periodically.
class WindowCheck {
 public:
  explicit WindowCheck(const bench_files::BenchFile& bench) : bench_(bench) {}

  /// Message for the panel; empty: the window is correct. Allocates only on a change.
  const std::string& error_message(const loop::Sink& sink);
  /// The same for the log, returned once.
  std::string take_warning();

 private:
  const bench_files::BenchFile& bench_;
  int n_calls_ = 0;
  bool was_warned_ = false;
  render::WindowGeometry place_;
  std::vector<render::Monitor> monitors_;
  std::string error_message_, warning_;
};

}  // namespace vrda::bench
