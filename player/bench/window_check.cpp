#include "bench/window_check.hpp"

#include <utility>

namespace vrda::bench {
namespace {

/// Error of surfaces by levels of detail (render::RenderOptions), below the resolution of the eye.
constexpr double coarseness_px = 0.5;

}  // namespace

std::optional<InputError::Facts> window_mismatch(const bench_files::BenchFile& bench,
                                                 const std::optional<render::WindowGeometry>& place)
{
  if (!place) return std::nullopt;
  const auto text = [](int a, const char* between, int b) {
    return std::to_string(a) + between + std::to_string(b);
  };
  const bench_files::DisplaySettings& display = bench.display;
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

const std::string& WindowCheck::trouble(const loop::Sink& sink)
{
  constexpr int every = 30;  // frames: placing and querying a window takes time
  if (++n_calls_ % every != 0) return trouble_;
  const std::optional<InputError::Facts> facts = window_mismatch(
      bench_, sink.window() == nullptr ? std::nullopt : std::optional(sink.window()->geometry()));
  if (!facts) {
    trouble_.clear();
    return trouble_;
  }
  trouble_ = "found " + facts->found + ", wanted " + facts->wanted;
  if (!std::exchange(was_warned_, true)) warning_ = InputError(*facts).what();
  return trouble_;
}

std::string WindowCheck::take_warning()
{
  return std::exchange(warning_, {});
}

loop::Sink bench_window(const bench_files::BenchFile& bench, const std::string& title, int samples)
{
  render::WindowOptions options;
  options.width = bench.display.width;
  options.height = bench.display.height;
  options.title = title;
  options.samples = samples;
  options.is_vsynced = false;
  options.is_resizable = false;
  options.at = bench.display.at;
  options.alternative = "--headless";
  return loop::Sink(options);
}

loop::Sink bench_memory(const bench_files::BenchFile& bench, int samples)
{
  return loop::Sink(render::RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

}  // namespace vrda::bench
