#include "app/bench_screen.hpp"

#include "app/window_key.hpp"
#include "render/window.hpp"

namespace vrda {
namespace {

/// Half a pixel is not seen.
constexpr double coarseness_px = 0.5;

class BenchWindow final : public BenchScreen {
 public:
  explicit BenchWindow(const WindowOptions& options) : window_(options) {}

  Renderer& renderer() override { return window_.renderer(); }
  void show(const Scene& scene, std::span<const Shot> shots, const Overlay& words) override
  {
    window_.show(scene, shots, &words);
  }
  const Image& picture(const Scene& scene, std::span<const Shot> shots, const Overlay& words) override
  {
    return window_.renderer().draw(scene, shots, &words);
  }
  const std::vector<KeyPress>& keys() override
  {
    keys_.clear();
    for (const InputEvent& event : window_.events()) {
      if (event.kind != InputKind::key_press) continue;
      const Key key = key_of_window(event.key);
      if (key != Key::none) keys_.push_back({key, event.has_shift, event.has_control});
    }
    return keys_;
  }
  bool should_close() const override { return window_.should_close(); }

 private:
  Window window_;
  std::vector<KeyPress> keys_;
};

class BenchMemory final : public BenchScreen {
 public:
  explicit BenchMemory(const RenderOptions& options) : renderer_(make_offscreen_renderer(options)) {}

  Renderer& renderer() override { return *renderer_; }
  void show(const Scene& scene, std::span<const Shot> shots, const Overlay& words) override
  {
    renderer_->present(scene, shots, &words);
  }
  const Image& picture(const Scene& scene, std::span<const Shot> shots, const Overlay& words) override
  {
    return renderer_->draw(scene, shots, &words);
  }
  const std::vector<KeyPress>& keys() override { return keys_; }
  bool should_close() const override { return false; }

 private:
  std::unique_ptr<Renderer> renderer_;
  std::vector<KeyPress> keys_;
};

}  // namespace

std::unique_ptr<BenchScreen> open_bench_window(const BenchFile& bench, const std::string& title, int samples)
{
  WindowOptions options;
  options.width = bench.display.width;
  options.height = bench.display.height;
  options.title = title;
  options.samples = samples;
  options.is_vsynced = false;
  return std::make_unique<BenchWindow>(options);
}

std::unique_ptr<BenchScreen> open_bench_memory(const BenchFile& bench, int samples)
{
  return std::make_unique<BenchMemory>(
      RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

}  // namespace vrda
