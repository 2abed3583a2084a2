#include "app/bench_screen.hpp"

#include <utility>

#include "app/window_key.hpp"

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
      const Key key = key_of_window(event.key, event.has_shift);
      if (key != Key::none) keys_.push_back({key, event.has_shift, event.has_control});
    }
    return keys_;
  }
  bool should_close() const override { return window_.should_close(); }
  std::optional<WindowPlace> place() const override { return window_.place(); }

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
  std::optional<WindowPlace> place() const override { return std::nullopt; }

 private:
  std::unique_ptr<Renderer> renderer_;
  std::vector<KeyPress> keys_;
};

}  // namespace

std::optional<InputError::Facts> misplaced(const BenchFile& bench, const std::optional<WindowPlace>& place)
{
  if (!place) return std::nullopt;
  const auto text = [](int a, const char* between, int b) {
    return std::to_string(a) + between + std::to_string(b);
  };
  const DisplaySettings& display = bench.display;
  if (place->width != display.width || place->height != display.height) {
    return InputError::Facts{bench.path, "display.width, display.height",
                             "a frame buffer of " + text(place->width, " x ", place->height),
                             text(display.width, " x ", display.height)};
  }
  if (display.at && (place->x != (*display.at)[0] || place->y != (*display.at)[1])) {
    return InputError::Facts{bench.path, "display.at", "a window at " + text(place->x, ", ", place->y),
                             text((*display.at)[0], ", ", (*display.at)[1])};
  }
  return std::nullopt;
}

const std::string& ScreenWatch::trouble(const BenchScreen& screen)
{
  constexpr int every = 30;  // pictures: a desktop takes a while to place a window, and to be asked
  if (++n_calls_ % every != 0) return trouble_;
  const std::optional<InputError::Facts> facts = misplaced(bench_, screen.place());
  if (!facts) {
    trouble_.clear();
    return trouble_;
  }
  trouble_ = "found " + facts->found + ", wanted " + facts->wanted;
  if (!std::exchange(was_warned_, true)) warning_ = InputError(*facts).what();
  return trouble_;
}

std::string ScreenWatch::take_warning()
{
  return std::exchange(warning_, {});
}

std::unique_ptr<BenchScreen> open_bench_window(const BenchFile& bench, const std::string& title, int samples)
{
  WindowOptions options;
  options.width = bench.display.width;
  options.height = bench.display.height;
  options.title = title;
  options.samples = samples;
  options.is_vsynced = false;
  options.is_resizable = false;
  options.at = bench.display.at;
  options.instead = "--headless";
  return std::make_unique<BenchWindow>(options);
}

std::unique_ptr<BenchScreen> open_bench_memory(const BenchFile& bench, int samples)
{
  return std::make_unique<BenchMemory>(
      RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

}  // namespace vrda
