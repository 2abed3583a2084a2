/// Where the bench's pictures go: a window on the display, or memory.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/renderer.hpp"
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
};

/// A window as large as the frame buffer; without vertical synchronisation, since the loop keeps the pace.
/// Throws InputError when there is no display.
std::unique_ptr<BenchScreen> open_bench_window(const BenchFile& bench, const std::string& title, int samples);
std::unique_ptr<BenchScreen> open_bench_memory(const BenchFile& bench, int samples);

}  // namespace vrda
