/// The bench's window or memory, and whether the window is where calibrated numbers want it.
#pragma once

#include <optional>
#include <string>

#include "core/error.hpp"
#include "loop/sink.hpp"
#include "setup/bench_file.hpp"

namespace vrda {

/// A window of the frame buffer's size, at the bench file's place if it has one; without vertical
/// synchronisation, since the loop keeps the pace. Throws InputError when there is no display.
Sink bench_window(const BenchFile& bench, const std::string& title, int samples);
Sink bench_memory(const BenchFile& bench, int samples);

/// Of pixels that are not where the bench file has them, and calibrated numbers with them; nothing: they are.
std::optional<InputError::Facts> misplaced(const BenchFile& bench, const std::optional<WindowPlace>& place);

/// Looks now and then whether a window is where it should be.
class ScreenWatch {
 public:
  explicit ScreenWatch(const BenchFile& bench) : bench_(bench) {}

  /// For the panel; empty: it is. Allocates only on a change.
  const std::string& trouble(const Sink& sink);
  /// The same for the log, once: empty from then on.
  std::string take_warning();

 private:
  const BenchFile& bench_;
  int n_calls_ = 0;
  bool was_warned_ = false;
  std::string trouble_, warning_;
};

}  // namespace vrda
