// Command `vrda-player devices`.
#include <array>
#include <chrono>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "bench/bench_run.hpp"
#include "bench/body_tracker.hpp"
#include "bench/measure_body.hpp"
#include "core/units.hpp"
#include "settings/settings_text.hpp"
#include "setup/bench_file.hpp"

namespace vrda {
namespace {

/// Last sample of each input; empty if none was received.
struct LastValues {
  explicit LastValues(const BenchFile& bench)
  {
    if (bench.tracker) tools.resize(bench.tracker->tools.size());
    for (std::size_t k = 0; k < n_body_roles; ++k) {
      if (bench.bodies[k] && !bench.bodies[k]->markers_body_mm.empty())
        bodies[k].emplace(*bench.bodies[k], first_tool_of(bench, static_cast<BodyRole>(k)));
    }
  }

  std::array<std::optional<BodyTracker>, n_body_roles> bodies;  ///< bodies of markers
  std::vector<std::optional<Sample>> tools;
  std::optional<Sample> potentiometer, stage;

  void take(const Sample& sample)
  {
    if (sample.kind == SampleKind::place && sample.source < tools.size()) tools[sample.source] = sample;
    if (sample.kind == SampleKind::place) take_marker(sample);
    if (sample.kind == SampleKind::potentiometer) potentiometer = sample;
    if (sample.kind == SampleKind::stage) stage = sample;
  }
  void take_marker(const Sample& sample)
  {
    for (std::optional<BodyTracker>& body : bodies) {
      if (!body || !body->has_tool(sample.source)) continue;
      if (body->has_come(sample.source)) body->settle();
      body->take(sample, s_per_ns * static_cast<double>(sample.arrival_ns));
    }
  }
};

const char* name_of(SeenState state)
{
  constexpr std::array<const char*, 4> names{"seen", "missing", "stale", "not a place"};
  return names[static_cast<std::size_t>(state)];
}

std::string place_text(const Place& place)
{
  std::string text;
  for (const double v : place.position_mm) text += (text.empty() ? "" : ", ") + rounded_text(v, 2);
  return text;
}

void write_report(std::ostream& out, const std::string& name, const DeviceReport& report)
{
  out << name << "  " << report.peer << "  " << (report.link == LinkState::up ? "answers" : "does not answer")
      << "  " << rounded_text(report.rate_hz, 1) << " samples a second";
  if (report.n_refused > 0) out << "  " << report.n_refused << " rejected";
  if (!report.trouble.empty()) out << "  (" << report.trouble << ")";
  out << "\n";
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
    const auto state = static_cast<SeenState>(values.tools[k]->state);
    out << name_of(state);
    if (state == SeenState::seen) out << "  " << place_text(values.tools[k]->place) << " mm";
    out << "\n";
  }
  for (std::size_t k = 0; k < n_body_roles; ++k) {
    if (!bench.bodies[k] || bench.bodies[k]->markers.empty()) continue;
    const char* const role = name_of(static_cast<BodyRole>(k));
    out << "  body " << role << "  "
        << (values.bodies[k] ? fit_text(values.bodies[k]->fit())
                             : "no markers_mm yet: vrda-player body " + std::string(role))
        << "\n";
  }
  if (!bench.board) return;
  write_report(out, "board", devices.report(DeviceId::board));
  if (values.potentiometer) out << "  potentiometer  " << values.potentiometer->count << " of 1023\n";
  if (values.stage) {
    out << "  stage  " << rounded_text(bench.stage_mm_per_count * values.stage->count, 3) << " mm"
        << ((values.stage->state & stage_zeroed) != 0 ? "" : ", not zeroed") << "\n";
  }
}

/// JSON and TOML strings have the same escapes, so quoted_text() is valid here.
std::string json_of(const DeviceReport& report)
{
  return "\"peer\": " + quoted_text(report.peer) +
         ", \"answers\": " + (report.link == LinkState::up ? "true" : "false") +
         ", \"rate_hz\": " + rounded_text(report.rate_hz, 2) +
         ", \"samples\": " + std::to_string(report.n_samples) +
         ", \"refused\": " + std::to_string(report.n_refused) +
         ", \"lost\": " + std::to_string(report.n_lost) + ", \"trouble\": " + quoted_text(report.trouble);
}

std::string json_of(BodyRole role, const PoseFit& fit)
{
  const FitQuality quality = quality_of(fit);
  return std::string("{\"role\": \"") + name_of(role) + "\", \"status\": \"" + name_of(fit.status) +
         "\", \"markers\": " + std::to_string(quality.n_markers) +
         ", \"residual_mm\": " + rounded_text(quality.residual_mm, 4) +
         ", \"turn_sd_deg\": " + rounded_text(quality.turn_sd_deg, 4) +
         ", \"middle_sd_mm\": " + rounded_text(quality.middle_sd_mm, 4) + "}";
}

void write_json(std::ostream& out, const BenchFile& bench, const Devices& devices, const LastValues& values)
{
  out << "{\"tracker\": {" << json_of(devices.report(DeviceId::tracker)) << ", \"tools\": [";
  for (std::size_t k = 0; k < values.tools.size(); ++k) {
    out << (k == 0 ? "" : ", ") << "{\"name\": " << quoted_text(bench.tracker->tools[k]) << ", \"state\": ";
    if (!values.tools[k]) {
      out << "null}";
      continue;
    }
    out << "\"" << name_of(static_cast<SeenState>(values.tools[k]->state)) << "\", \"position_mm\": ["
        << place_text(values.tools[k]->place) << "]}";
  }
  out << "], \"bodies\": [";
  const char* comma = "";
  for (std::size_t k = 0; k < n_body_roles; ++k) {
    if (!values.bodies[k]) continue;
    out << comma << json_of(static_cast<BodyRole>(k), values.bodies[k]->fit());
    comma = ", ";
  }
  out << "]}";
  if (bench.board) {
    out << ", \"board\": {" << json_of(devices.report(DeviceId::board)) << ", \"potentiometer\": "
        << (values.potentiometer ? std::to_string(values.potentiometer->count) : "null") << ", \"stage_mm\": "
        << (values.stage ? rounded_text(bench.stage_mm_per_count * values.stage->count, 3) : "null") << "}";
  }
  out << "}\n";
}

}  // namespace

void listen(Devices& devices, double seconds, StopSignals& stop,
            const std::function<void(const Sample&)>& take)
{
  constexpr std::chrono::milliseconds between{5};
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end &&
         !stop.came_by(std::chrono::steady_clock::now() + between)) {
    for (Sample sample; devices.take(sample);) take(sample);
  }
}

int list_devices(const DevicesOptions& options, const Streams& streams)
{
  const BenchFile bench = read_bench_file(options.bench, MarkerPlaces::may_be_missing);
  StopSignals stop;
  Devices devices(bench.tracker, bench.board);
  LastValues values(bench);
  listen(devices, options.seconds, stop, [&](const Sample& sample) { values.take(sample); });
  if (options.has_json) {
    write_json(streams.data, bench, devices, values);
  } else {
    write_table(streams.data, bench, devices, values);
  }
  const auto is_silent = [&](DeviceId device) { return devices.report(device).link != LinkState::up; };
  return (bench.tracker && is_silent(DeviceId::tracker) ? 1 : 0) +
         (bench.board && is_silent(DeviceId::board) ? 1 : 0);
}

}  // namespace vrda
