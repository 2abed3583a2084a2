#include "bench/window_check.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "show/loop.hpp"

namespace vrda::bench {
namespace {

/// Error of surfaces by levels of detail (view::RenderOptions), below the resolution of the eye.
constexpr double coarseness_px = 0.5;

}  // namespace

namespace {

std::string pair_text(int a, const char* between, int b)
{
  return std::to_string(a) + between + std::to_string(b);
}

const view::Monitor& monitor_named(const bench::BenchFile& bench, const std::string& name,
                                     std::span<const view::Monitor> monitors)
{
  const auto found = std::ranges::find(monitors, name, &view::Monitor::name);
  if (found != monitors.end()) return *found;
  std::string names;
  for (const view::Monitor& monitor : monitors) names += (names.empty() ? "" : ", ") + monitor.name;
  throw InputError({bench.path, "display.outputs", "\"" + name + "\"",
                    names.empty() ? "a connected monitor; no monitor is connected" : "one of " + names});
}

/// The part of the area that monitors display, at most 1; of monitors that show the same the first counts.
double displayed_share(const view::WindowGeometry& area, std::span<const view::Monitor> monitors)
{
  double shown = 0.0;
  for (std::size_t k = 0; k < monitors.size(); ++k) {
    const view::WindowGeometry& m = monitors[k].geometry;
    const bool is_copy = std::ranges::any_of(monitors.first(k), [&](const view::Monitor& other) {
      return other.geometry.x == m.x && other.geometry.y == m.y;
    });
    const int width = std::min(area.x + area.width, m.x + m.width) - std::max(area.x, m.x);
    const int height = std::min(area.y + area.height, m.y + m.height) - std::max(area.y, m.y);
    if (!is_copy && width > 0 && height > 0) shown += static_cast<double>(width) * height;
  }
  return std::min(1.0, shown / (static_cast<double>(area.width) * area.height));
}

std::optional<InputError::Facts> hidden_part(const bench::BenchFile& bench,
                                             const view::WindowGeometry& place,
                                             std::span<const view::Monitor> monitors)
{
  if (monitors.empty() || place.width <= 0 || place.height <= 0) return std::nullopt;
  const double shown = displayed_share(place, monitors);
  if (shown >= 1.0) return std::nullopt;
  const std::string where =
      " (" + pair_text(place.width, " x ", place.height) + " at " + pair_text(place.x, ", ", place.y) + ")";
  return InputError::Facts{
      bench.path, "display.at",
      (shown == 0.0 ? "a window off every screen" : "a window partly off the screens") + where,
      "a window within the screens"};
}

}  // namespace

std::optional<std::array<int, 2>> window_position(const bench::BenchFile& bench,
                                                  std::span<const view::Monitor> monitors)
{
  const bench::DisplaySettings& display = bench.display;
  if (display.outputs.empty()) return display.at;
  const view::WindowGeometry& left = monitor_named(bench, display.outputs.front(), monitors).geometry;
  if (display.outputs.size() == 2) {
    const view::WindowGeometry& right = monitor_named(bench, display.outputs.back(), monitors).geometry;
    const int wanted_x = left.x + display.windows.right.x;
    if (right.x != wanted_x || right.y != left.y) {
      throw InputError({bench.path, "display.outputs",
                        "\"" + display.outputs.back() + "\" at " + pair_text(right.x, ", ", right.y),
                        "the right eye's monitor at " + pair_text(wanted_x, ", ", left.y) +
                            ": arrange the desktop so, or exchange the names"});
    }
  }
  return std::array{left.x, left.y};
}

std::optional<InputError::Facts> window_mismatch(const bench::BenchFile& bench,
                                                 const std::optional<view::WindowGeometry>& place,
                                                 std::span<const view::Monitor> monitors)
{
  if (!place) return std::nullopt;
  const bench::DisplaySettings& display = bench.display;
  if (place->width != display.width || place->height != display.height) {
    return InputError::Facts{bench.path, "display.width, display.height",
                             "a frame buffer of " + pair_text(place->width, " x ", place->height),
                             pair_text(display.width, " x ", display.height)};
  }
  std::optional<std::array<int, 2>> wanted;
  // A monitor may be unplugged meanwhile.
  if (const auto refused = show::catch_input_error([&] { wanted = window_position(bench, monitors); }))
    return refused->facts();
  if (wanted && (place->x != (*wanted)[0] || place->y != (*wanted)[1])) {
    return InputError::Facts{bench.path, display.outputs.empty() ? "display.at" : "display.outputs",
                             "a window at " + pair_text(place->x, ", ", place->y),
                             pair_text((*wanted)[0], ", ", (*wanted)[1])};
  }
  return hidden_part(bench, *place, monitors);
}

const std::string& WindowCheck::error_message(const show::Sink& sink)
{
  constexpr int every = 30;  // frames: placing and querying a window takes time
  if (++n_calls_ % every != 0) return error_message_;
  const view::Window* const window = sink.window();
  if (window == nullptr) return error_message_;
  // Monitors are queried again when the window moved, and every 10 s at 60 frames a second.
  constexpr int every_check = 20;
  const view::WindowGeometry place = window->geometry();
  if (place != place_ || n_calls_ / every % every_check == 1) monitors_ = window->monitors();
  place_ = place;
  const std::optional<InputError::Facts> facts = window_mismatch(bench_, place, monitors_);
  if (!facts) {
    error_message_.clear();
    return error_message_;
  }
  error_message_ = "found " + facts->found + ", wanted " + facts->wanted;
  if (!std::exchange(was_warned_, true)) warning_ = InputError(*facts).what();
  return error_message_;
}

std::string WindowCheck::take_warning()
{
  return std::exchange(warning_, {});
}

show::Sink bench_window(const bench::BenchFile& bench, const std::string& title, int samples)
{
  view::WindowOptions options;
  options.width = bench.display.width;
  options.height = bench.display.height;
  options.title = title;
  options.samples = samples;
  options.is_vsynced = false;
  options.is_resizable = false;
  options.at = window_position(
      bench, bench.display.outputs.empty() ? std::vector<view::Monitor>{} : view::connected_monitors());
  options.alternative = "--headless";
  return show::Sink(options);
}

show::Sink bench_memory(const bench::BenchFile& bench, int samples)
{
  return show::Sink(view::RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

}  // namespace vrda::bench
