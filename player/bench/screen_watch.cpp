#include "bench/screen_watch.hpp"

#include <utility>

namespace vrda {
namespace {

/// Below the resolution of the eye.
constexpr double coarseness_px = 0.5;

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

const std::string& ScreenWatch::trouble(const Sink& sink)
{
  constexpr int every = 30;  // frames: placing and querying a window takes time
  if (++n_calls_ % every != 0) return trouble_;
  const std::optional<InputError::Facts> facts =
      misplaced(bench_, sink.window() == nullptr ? std::nullopt : std::optional(sink.window()->place()));
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

Sink bench_window(const BenchFile& bench, const std::string& title, int samples)
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
  return Sink(options);
}

Sink bench_memory(const BenchFile& bench, int samples)
{
  return Sink(RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

}  // namespace vrda
