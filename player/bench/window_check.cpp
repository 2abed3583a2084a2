#include "bench/window_check.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench_file.hpp"
#include "bench/bench_run.hpp"
#include "bench/body_tracker.hpp"
#include "bench/devices.hpp"
#include "core/units.hpp"
#include "show/loop.hpp"
#include "show/session.hpp"
#include "view/window.hpp"

namespace vrda::bench {
namespace {

/// Error of surfaces by levels of detail (view::RenderOptions), below the resolution of the eye.
constexpr double coarseness_px = 0.5;

std::string pair_text(int a, const char* between, int b)
{
  return std::to_string(a) + between + std::to_string(b);
}

const view::Monitor& monitor_named(const BenchFile& bench, const std::string& name,
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

std::optional<InputError::Facts> hidden_part(const BenchFile& bench, const view::WindowGeometry& place,
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

std::optional<std::array<int, 2>> window_position(const BenchFile& bench,
                                                  std::span<const view::Monitor> monitors)
{
  const DisplaySettings& display = bench.display;
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

std::optional<InputError::Facts> window_mismatch(const BenchFile& bench,
                                                 const std::optional<view::WindowGeometry>& place,
                                                 std::span<const view::Monitor> monitors)
{
  if (!place) return std::nullopt;
  const DisplaySettings& display = bench.display;
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

show::Sink bench_window(const BenchFile& bench, const std::string& title, int samples)
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

show::Sink bench_memory(const BenchFile& bench, int samples)
{
  return show::Sink(view::RenderOptions{bench.display.width, bench.display.height, samples, coarseness_px});
}

// Command `vrda-player devices`.

namespace {

/// Last sample of each input; empty if none was received.
struct LastValues {
  explicit LastValues(const BenchFile& bench)
      : bodies(bench), tools(bench.tracker->tools.size()), rates(tools.size())
  {
  }

  TrackedBodies bodies;
  std::vector<std::optional<Sample>> tools;
  std::vector<RateMeter> rates;  ///< of the tools' samples that are not missing
  std::optional<Sample> potentiometer, stage;

  void take(const Sample& sample)
  {
    if (sample.kind == SampleKind::tool_pose && sample.source < tools.size()) {
      tools[sample.source] = sample;
      if (sample.is(ToolVisibility::seen)) rates[sample.source].count(sample.arrival_ns);
    }
    if (sample.kind == SampleKind::tool_pose)
      bodies.take(sample, [](BodyTracker& body) { body.end_message(); });
    if (sample.kind == SampleKind::potentiometer) potentiometer = sample;
    if (sample.kind == SampleKind::stage) stage = sample;
  }
  /// Of a body of markers with known positions, or nullptr.
  const PoseFit* fit(std::size_t role) const
  {
    const std::optional<BodyTracker>& body = bodies[static_cast<BodyRole>(role)];
    return body && body->has_markers() ? &body->fit() : nullptr;
  }
};

const char* name_of(ToolVisibility state)
{
  return std::array{"seen", "missing", "stale", "not a place"}.at(static_cast<std::size_t>(state));
}

std::string place_text(const ToolPose& place)
{
  std::string text;
  for (const double v : place.position_mm) text += (text.empty() ? "" : ", ") + show::rounded_text(v, 2);
  return text;
}

void write_report(std::ostream& out, const std::string& name, const DeviceReport& report)
{
  out << name << "  " << report.peer << "  " << (report.link == LinkState::up ? "answers" : "does not answer")
      << "  " << show::rounded_text(report.rate_hz, 1) << " samples a second";
  if (report.n_refused > 0) out << "  " << report.n_refused << " rejected";
  if (!report.error_message.empty()) out << "  (" << report.error_message << ")";
  out << "\n";
  for (const std::string& note : report.notes) out << "  note: " << note << "\n";
}

void write_monitors(std::ostream& out, const std::vector<view::Monitor>& monitors)
{
  if (monitors.empty()) out << "no monitor: there is no display\n";
  for (const view::Monitor& monitor : monitors) {
    const view::WindowGeometry& g = monitor.geometry;
    out << "monitor  " << monitor.name << "  " << g.width << " x " << g.height << " at " << g.x << ", " << g.y
        << ", " << monitor.refresh_hz << " Hz\n";
  }
}

void write_table(std::ostream& out, const BenchFile& bench, const Devices& devices, const LastValues& values)
{
  write_report(out, "tracker", devices.report(DeviceId::tracker));
  for (std::size_t k = 0; k < values.tools.size(); ++k) {
    out << "  " << bench.tracker->tools[k] << "  ";
    if (!values.tools[k]) {
      out << "nothing yet\n";
      continue;
    }
    const auto state = static_cast<ToolVisibility>(values.tools[k]->state);
    out << name_of(state);
    if (state == ToolVisibility::seen) out << "  " << place_text(values.tools[k]->tool_pose) << " mm";
    out << "  " << show::rounded_text(values.rates[k].rate_hz(devices.now_ns()), 1) << " a second";
    out << "\n";
  }
  for (std::size_t k = 0; k < n_body_roles; ++k) {
    if (!bench.bodies[k] || bench.bodies[k]->markers.empty()) continue;
    const char* const role = name_of(static_cast<BodyRole>(k));
    out << "  body " << role << "  "
        << (values.fit(k) != nullptr ? fit_text(*values.fit(k))
                                     : "no markers_mm yet: vrda-player body " + std::string(role))
        << "\n";
  }
  if (!bench.board) return;
  write_report(out, "board", devices.report(DeviceId::board));
  if (values.potentiometer) out << "  potentiometer  " << values.potentiometer->count << " of 1023\n";
  if (values.stage) {
    out << "  stage  " << show::rounded_text(bench.stage_mm_per_count * values.stage->count, 3) << " mm"
        << ((values.stage->state & stage_zeroed) != 0 ? "" : ", not zeroed") << "\n";
  }
}

/// JSON and TOML strings have the same escapes, so core::quoted_text() is valid here.
std::string json_of(const DeviceReport& report)
{
  std::string notes;
  for (const std::string& note : report.notes) notes += (notes.empty() ? "" : ", ") + core::quoted_text(note);
  return "\"peer\": " + core::quoted_text(report.peer) +
         ", \"answers\": " + (report.link == LinkState::up ? "true" : "false") +
         ", \"rate_hz\": " + show::rounded_text(report.rate_hz, 2) +
         ", \"samples\": " + std::to_string(report.n_samples) +
         ", \"refused\": " + std::to_string(report.n_refused) +
         ", \"lost\": " + std::to_string(report.n_lost) +
         ", \"trouble\": " + core::quoted_text(report.error_message) + ", \"notes\": [" + notes + "]";
}

std::string json_of(BodyRole role, const PoseFit& fit)
{
  const FitQuality quality = quality_of(fit);
  return std::string("{\"role\": \"") + name_of(role) + "\", \"status\": \"" + name_of(fit.status) +
         "\", \"markers\": " + std::to_string(quality.n_markers) +
         ", \"residual_mm\": " + show::rounded_text(quality.residual_mm, 4) +
         ", \"turn_sd_deg\": " + show::rounded_text(deg_from_rad(quality.rotation_sd_rad), 4) +
         ", \"middle_sd_mm\": " + show::rounded_text(quality.centroid_sd_mm, 4) + "}";
}

void write_json(std::ostream& out, const BenchFile& bench, const Devices& devices, const LastValues& values)
{
  out << "{\"tracker\": {" << json_of(devices.report(DeviceId::tracker)) << ", \"tools\": [";
  for (std::size_t k = 0; k < values.tools.size(); ++k) {
    out << (k == 0 ? "" : ", ") << "{\"name\": " << core::quoted_text(bench.tracker->tools[k])
        << ", \"state\": ";
    if (!values.tools[k]) {
      out << "null}";
      continue;
    }
    out << "\"" << name_of(static_cast<ToolVisibility>(values.tools[k]->state))
        << "\", \"rate_hz\": " << show::rounded_text(values.rates[k].rate_hz(devices.now_ns()), 2)
        << ", \"position_mm\": [" << place_text(values.tools[k]->tool_pose) << "]}";
  }
  out << "], \"bodies\": [";
  const char* comma = "";
  for (std::size_t k = 0; k < n_body_roles; ++k) {
    if (values.fit(k) == nullptr) continue;
    out << comma << json_of(static_cast<BodyRole>(k), *values.fit(k));
    comma = ", ";
  }
  out << "]}";
  if (bench.board) {
    out << ", \"board\": {" << json_of(devices.report(DeviceId::board)) << ", \"potentiometer\": "
        << (values.potentiometer ? std::to_string(values.potentiometer->count) : "null") << ", \"stage_mm\": "
        << (values.stage ? show::rounded_text(bench.stage_mm_per_count * values.stage->count, 3) : "null")
        << "}";
  }
  out << ", \"monitors\": [";
  comma = "";
  for (const view::Monitor& monitor : view::connected_monitors()) {
    const view::WindowGeometry& g = monitor.geometry;
    out << comma << "{\"name\": " << core::quoted_text(monitor.name) << ", \"x\": " << g.x
        << ", \"y\": " << g.y << ", \"width\": " << g.width << ", \"height\": " << g.height
        << ", \"refresh_hz\": " << monitor.refresh_hz << "}";
    comma = ", ";
  }
  out << "]}\n";
}

}  // namespace

void receive_samples(Devices& devices, double seconds, show::StopSignals& stop,
                     const std::function<void(const Sample&)>& take)
{
  constexpr std::chrono::milliseconds between{5};
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end &&
         !stop.wait_until(std::chrono::steady_clock::now() + between)) {
    for (Sample sample; devices.take(sample);) take(sample);
  }
}

int list_devices(const DevicesOptions& options, const show::Streams& streams)
{
  const BenchFile bench = read_bench_file(options.bench, MarkerPositions::optional);
  show::StopSignals stop;
  Devices devices(bench.tracker, bench.board);
  LastValues values(bench);
  receive_samples(devices, options.seconds, stop, [&](const Sample& sample) { values.take(sample); });
  if (options.has_json) {
    write_json(streams.data, bench, devices, values);
  } else {
    write_table(streams.data, bench, devices, values);
    write_monitors(streams.data, view::connected_monitors());
  }
  const auto is_silent = [&](DeviceId device) { return devices.report(device).link != LinkState::up; };
  return (is_silent(DeviceId::tracker) ? 1 : 0) + (bench.board && is_silent(DeviceId::board) ? 1 : 0);
}

}  // namespace vrda::bench
