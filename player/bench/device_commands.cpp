// Commands that look at the devices: `vrda-player devices` lists them, `vrda-player body` measures a body of
// markers.
#include <algorithm>
#include <chrono>
#include <ostream>
#include <sstream>

#include "bench/bench_run.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "show/session.hpp"
#include "view/window.hpp"

namespace vrda::bench {

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
      bodies.take(sample, [this](BodyRole role) { bodies[role]->end_message(); });
    if (sample.kind == SampleKind::potentiometer) potentiometer = sample;
    if (sample.kind == SampleKind::stage) stage = sample;
  }
  /// Of a body of markers with known positions, or nullptr.
  const PoseFit* fit(BodyRole role) const
  {
    const std::optional<BodyTracker>& body = bodies[role];
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
  for (const double v : place.position_mm) text += (text.empty() ? "" : ", ") + short_decimal(v, 2);
  return text;
}

void write_report(std::ostream& out, const std::string& name, const DeviceReport& report)
{
  out << name << "  " << report.peer << "  " << (report.link == LinkState::up ? "answers" : "does not answer")
      << "  " << short_decimal(report.rate_hz, 1) << " samples a second";
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
    out << "  " << short_decimal(values.rates[k].rate_hz(devices.now_ns()), 1) << " a second";
    out << "\n";
  }
  for (const BodyRole role : body_roles) {
    if (!bench.bodies[role] || bench.bodies[role]->markers.empty()) continue;
    const PoseFit* const fit = values.fit(role);
    const std::string name = name_of(role);
    out << "  body " << name << "  "
        << (fit != nullptr ? fit_text(*fit) : "no markers_mm yet: vrda-player body " + name) << "\n";
  }
  if (!bench.board) return;
  write_report(out, "board", devices.report(DeviceId::board));
  if (values.potentiometer) out << "  potentiometer  " << values.potentiometer->count << " of 1023\n";
  if (values.stage) {
    out << "  stage  " << short_decimal(bench.stage_mm_per_count * values.stage->count, 3) << " mm"
        << ((values.stage->state & stage_zeroed) != 0 ? "" : ", not zeroed") << "\n";
  }
}

using Json = core::DocumentValue;

Json json_of(const DeviceReport& report)
{
  return {{"peer", report.peer},
          {"answers", report.link == LinkState::up},
          {"rate_hz", rounded(report.rate_hz, 2)},
          {"samples", report.n_samples},
          {"refused", report.n_refused},
          {"lost", report.n_lost},
          {"trouble", report.error_message},
          {"notes", report.notes}};
}

Json json_of(BodyRole role, const PoseFit& fit)
{
  const FitQuality quality = quality_of(fit);
  return {{"role", name_of(role)},
          {"status", name_of(fit.status)},
          {"markers", quality.n_markers},
          {"residual_mm", rounded(quality.residual_mm, 4)},
          {"turn_sd_deg", rounded(deg_from_rad(quality.rotation_sd_rad), 4)},
          {"middle_sd_mm", rounded(quality.centroid_sd_mm, 4)}};
}

Json tools_json(const BenchFile& bench, const Devices& devices, const LastValues& values)
{
  Json tools = Json::array();
  for (std::size_t k = 0; k < values.tools.size(); ++k) {
    Json& tool = tools.emplace_back(Json{{"name", bench.tracker->tools[k]}, {"state", nullptr}});
    if (!values.tools[k]) continue;
    tool["state"] = name_of(static_cast<ToolVisibility>(values.tools[k]->state));
    tool["rate_hz"] = rounded(values.rates[k].rate_hz(devices.now_ns()), 2);
    for (const double mm : values.tools[k]->tool_pose.position_mm)
      tool["position_mm"].push_back(rounded(mm, 2));
  }
  return tools;
}

void write_json(std::ostream& out, const BenchFile& bench, const Devices& devices, const LastValues& values)
{
  Json json;
  Json& tracker = json["tracker"] = json_of(devices.report(DeviceId::tracker));
  tracker["tools"] = tools_json(bench, devices, values);
  Json& bodies = tracker["bodies"] = Json::array();
  for (const BodyRole role : body_roles) {
    if (values.fit(role) != nullptr) bodies.push_back(json_of(role, *values.fit(role)));
  }
  if (bench.board) {
    Json& board = json["board"] = json_of(devices.report(DeviceId::board));
    board["potentiometer"] = values.potentiometer ? Json(values.potentiometer->count) : Json();
    board["stage_mm"] =
        values.stage ? Json(rounded(bench.stage_mm_per_count * values.stage->count, 3)) : Json();
  }
  Json& monitors = json["monitors"] = Json::array();
  for (const view::Monitor& monitor : view::connected_monitors()) {
    const view::WindowGeometry& g = monitor.geometry;
    monitors.push_back({{"name", monitor.name},
                        {"x", g.x},
                        {"y", g.y},
                        {"width", g.width},
                        {"height", g.height},
                        {"refresh_hz", monitor.refresh_hz}});
  }
  out << json_text(json, -1) << "\n";
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

// Measuring a body.

namespace {

/// The mean of 500 frames has 1/20 of the noise of one, which is below the systematic error of a tracker.
constexpr std::size_t most_frames = 500;

std::string key_of(BodyRole role)
{
  return std::string("body.") + name_of(role);
}

const BodySettings& settings_of(const BenchFile& bench, BodyRole role)
{
  return *bench.bodies[role];
}

BodyRole wanted_role(const BenchFile& bench, const std::string& name)
{
  std::vector<std::string> known;
  for (const BodyRole role : body_roles) {
    if (!bench.bodies[role] || bench.bodies[role]->markers.empty()) continue;
    if (name == name_of(role)) return role;
    known.emplace_back(name_of(role));
  }
  throw InputError({bench.path, "body",
                    known.empty() ? "no body of markers" : "no body of markers '" + name + "'",
                    known.empty() ? "a body with the key markers" : joined(known, " or ")});
}

void require_seen(const std::vector<MarkerRow>& frames, const BenchFile& bench, BodyRole role)
{
  const std::vector<std::string>& names = settings_of(bench, role).markers;
  std::vector<std::string> unseen;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (std::ranges::none_of(frames, [k](const MarkerRow& frame) { return frame[k].has_value(); }))
      unseen.push_back("'" + names[k] + "'");
  }
  if (unseen.empty()) return;
  throw InputError({bench.path, key_of(role) + ".markers",
                    joined(unseen) + " in none of " + std::to_string(frames.size()) + " frames",
                    "each marker visible together with three others"});
}

/// Rethrows an error of the body fit with the marker names of the file.
[[noreturn]] void refuse_named(const FitError& refusal, const BenchFile& bench, BodyRole role)
{
  const InputError::Facts& facts = refusal.facts();
  std::string what;
  for (const std::size_t marker : refusal.marks())
    what += (what.empty() ? "'" : "and '") + settings_of(bench, role).markers[marker] + "' ";
  if (what.empty() && facts.field != "markers") what = facts.field + ": ";
  throw InputError({bench.path, key_of(role) + ".markers", what + facts.found, facts.wanted});
}

std::string tracker_error_message(const DeviceReport& report)
{
  if (report.link == LinkState::up) return "the tracker answers";
  return "no tracker at " + report.peer + (report.error_message.empty() ? "" : ": " + report.error_message);
}

std::vector<MarkerRow> received_frames(const BenchFile& bench, BodyRole role, double seconds)
{
  show::StopSignals stop;
  Devices devices(bench.tracker, std::nullopt);
  MarkerFrames received(first_tool_index(bench, role), settings_of(bench, role).markers.size());
  receive_samples(devices, seconds, stop, [&](const Sample& sample) { received.take(sample); });
  std::vector<MarkerRow> frames = received.frames(most_frames);
  if (frames.empty()) {
    throw InputError({bench.path, key_of(role) + ".markers",
                      "none of them seen in " + short_decimal(seconds, 1) + " s (" +
                          tracker_error_message(devices.report(DeviceId::tracker)) + ")",
                      "markers that the tracker reports with these names"});
  }
  return frames;
}

/// Fit of all markers with the noise of the frames.
PoseFit typical_fit(const BuiltBody& built)
{
  PoseFit fit;
  fit.status = FitStatus::fitted;
  fit.residual_rms_mm = built.residual_rms_mm;
  MarkerRow all;
  for (Eigen::Index k = 0; k < built.body.markers_mm.rows(); ++k)
    all.emplace_back(built.body.markers_mm.row(k).transpose());
  fit.cloud = cloud_of(built.body, all);
  return fit;
}

}  // namespace

BuiltBody build_measured_body(const std::vector<MarkerRow>& frames, const BenchFile& bench, BodyRole role)
{
  require_seen(frames, bench, role);
  BodyOptions options;
  for (const Eigen::Vector3d& p : settings_of(bench, role).markers_body_mm) options.given_mm.emplace_back(p);
  try {
    return build_body(frames, bench.path, options);
  } catch (const FitError& refusal) {
    refuse_named(refusal, bench, role);
  }
}

std::string bench_file_lines(const BuiltBody& built, const BenchFile& bench, BodyRole role)
{
  const BodySettings& settings = settings_of(bench, role);
  std::ostringstream text;
  text << "[" << key_of(role) << "]\nmarkers = [";
  for (std::size_t k = 0; k < settings.markers.size(); ++k)
    text << (k == 0 ? "" : ", ") << core::quoted_text(settings.markers[k]);
  text << "]\nmarkers_mm = [";
  for (Eigen::Index k = 0; k < built.body.markers_mm.size(); ++k)
    text << (k == 0 ? "" : ", ") << short_decimal(built.body.markers_mm(k / 3, k % 3), 3);
  const FitQuality quality = quality_of(typical_fit(built));
  text << "]\n# from " << built.n_frames << " frames, " << built.n_refused
       << " with fewer than three markers excluded; residual " << short_decimal(built.residual_rms_mm, 3)
       << " mm (root mean square)\n# expected pose error with all markers: rotation "
       << short_decimal(deg_from_rad(quality.rotation_sd_rad), 3) << " degrees, centroid "
       << short_decimal(quality.centroid_sd_mm, 3) << " mm (standard deviations)\n";
  for (std::size_t k = 0; k < settings.markers.size(); ++k)
    text << "# " << settings.markers[k] << ": " << short_decimal(built.markers[k].residual_rms_mm, 3)
         << " mm in " << built.markers[k].n_frames << " frames\n";
  if (!settings.markers_body_mm.empty())
    text << "# in the frame of the bench file's markers_mm, difference "
         << short_decimal(built.given_rms_mm, 3) << " mm (root mean square)\n";
  if (built.status != BuildStatus::converged)
    text << "# not converged: too few frames with the same markers\n";
  return text.str();
}

void measure_body(const MeasureBodyOptions& options, const show::Streams& streams)
{
  const BenchFile bench = read_bench_file(options.bench, MarkerPositions::optional);
  const BodyRole role = wanted_role(bench, options.role);
  if (!options.is_quiet)
    streams.messages << "Rotate the body '" << name_of(role) << "' slowly in front of the tracker for "
                     << short_decimal(options.seconds, 1) << " s" << std::endl;
  const std::vector<MarkerRow> frames = received_frames(bench, role, options.seconds);
  streams.data << bench_file_lines(build_measured_body(frames, bench, role), bench, role);
}

}  // namespace vrda::bench
