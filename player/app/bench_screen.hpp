/// Where the bench's pictures go: a window on the display, or memory.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "render/renderer.hpp"
#include "render/window.hpp"
#include "setup/bench_file.hpp"
#include "view/keys.hpp"

namespace vrda {

class BenchScreen {
 public:
  virtual ~BenchScreen() = default;
  virtual Renderer& renderer() = 0;
  /// Draws and shows; returns when the picture is finished.
  virtual void show(const Scene& scene, std::span<const Shot> shots, const Overlay& words) = 0;
  /// The same, and the picture as an image. Valid until the next.
  virtual const Image& picture(const Scene& scene, std::span<const Shot> shots, const Overlay& words) = 0;
  /// What was pressed since the last call.
  virtual const std::vector<KeyPress>& keys() = 0;
  virtual bool should_close() const = 0;
  /// Where its pixels are, which may be elsewhere than asked for; nothing in memory.
  virtual std::optional<WindowPlace> place() const = 0;
};

/// Of pixels that are not where the bench file has them, and calibrated numbers with them; nothing: they are.
std::optional<InputError::Facts> misplaced(const BenchFile& bench, const std::optional<WindowPlace>& place);

/// Looks now and then whether a screen is where it should be.
class ScreenWatch {
 public:
  explicit ScreenWatch(const BenchFile& bench) : bench_(bench) {}

  /// For the panel; empty: it is. Allocates only on a change.
  const std::string& trouble(const BenchScreen& screen);
  /// The same for the log, once: empty from then on.
  std::string take_warning();

 private:
  const BenchFile& bench_;
  int n_calls_ = 0;
  bool was_warned_ = false;
  std::string trouble_, warning_;
};

/// A window of the frame buffer's size, at the bench file's place if it has one; without vertical
/// synchronisation, since the loop keeps the pace. Throws InputError when there is no display.
std::unique_ptr<BenchScreen> open_bench_window(const BenchFile& bench, const std::string& title, int samples);
std::unique_ptr<BenchScreen> open_bench_memory(const BenchFile& bench, int samples);

}  // namespace vrda
