#include "setup/bench_file.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/text.hpp"
#include "settings/settings_table.hpp"
#include "setup/parameters.hpp"
#include "setup/simulation_settings.hpp"
#include "setup/tool_name.hpp"

namespace vrda {
namespace {

constexpr double most_px = 16384;
constexpr std::size_t least_markers = 3, most_markers = 64;

Viewport window_of(const SettingsTable& display, const char* name, const DisplaySettings& settings)
{
  const std::vector<double> v = display.numbers(name, 4, {0.0, most_px});
  const Viewport window{static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]),
                        static_cast<int>(v[3])};
  const bool is_whole = std::all_of(v.begin(), v.end(), [](double x) { return x == static_cast<int>(x); });
  const bool fits = window.width > 0 && window.height > 0 && window.x + window.width <= settings.width &&
                    window.y + window.height <= settings.height;
  if (!is_whole || !fits) {
    display.refuse(name, "a rectangle that reaches beyond the frame buffer, or has no size",
                   "x, y, width, height in whole pixels within " + std::to_string(settings.width) + " x " +
                       std::to_string(settings.height));
  }
  return window;
}

std::array<int, 2> place_of(const SettingsTable& display)
{
  // Outputs may stand to the left of the first one, and above it.
  const std::vector<double> v = display.numbers("at", 2, {-most_px, most_px});
  const std::array<int, 2> at{static_cast<int>(v[0]), static_cast<int>(v[1])};
  if (at[0] != v[0] || at[1] != v[1])
    display.refuse("at", shortest(v[0]) + " and " + shortest(v[1]), "x and y in whole pixels");
  return at;
}

DisplaySettings display_of(const SettingsTable& root)
{
  DisplaySettings settings;
  const SettingsTable display = root.table("display");
  display.require_known({"width", "height", "layout", "left_window", "right_window", "refresh_hz", "at"});
  settings.width = display.whole("width", {16, most_px});
  settings.height = display.whole("height", {16, most_px});
  settings.layout = static_cast<Layout>(display.word("layout", layout_names()));
  settings.windows = eye_windows(settings.layout, settings.width, settings.height, root.file());
  if (display.has("left_window")) settings.windows.left = window_of(display, "left_window", settings);
  if (display.has("right_window")) settings.windows.right = window_of(display, "right_window", settings);
  const Viewport shared = within(settings.windows.left, settings.windows.right);
  if (shared.width > 0) {
    display.refuse("right_window", "a window over the left eye's", "one beside it: each eye has its own");
  }
  settings.refresh_hz = display.number_or("refresh_hz", settings.refresh_hz, {1.0, 1000.0});
  if (display.has("at")) settings.at = place_of(display);
  return settings;
}

void add_places(const SettingsTable& body, BodySettings& settings)
{
  const std::vector<double> flat =
      body.numbers("markers_mm", 3 * settings.markers.size(), {-largest_mm, largest_mm});
  for (std::size_t k = 0; k < flat.size(); k += 3)
    settings.markers_body_mm.emplace_back(flat[k], flat[k + 1], flat[k + 2]);
}

void add_markers(const SettingsTable& body, const char* role, MarkerPlaces places, BodySettings& settings)
{
  settings.markers = tool_names(body, "markers");
  if (settings.markers.size() < least_markers || settings.markers.size() > most_markers) {
    body.refuse("markers", std::to_string(settings.markers.size()) + " markers",
                std::to_string(least_markers) + " to " + std::to_string(most_markers));
  }
  if (body.has("markers_mm")) {
    add_places(body, settings);
  } else if (places == MarkerPlaces::needed) {
    body.refuse("markers_mm", "nothing",
                "x, y, z of each marker (vrda-player body " + std::string(role) + " measures them)");
  }
  settings.marker_interval_ms = body.number_or("marker_interval_ms", 0.0, {0.0, 100.0});
}

BodySettings body_of(const SettingsTable& bodies, const char* role, MarkerPlaces places)
{
  BodySettings settings;
  const SettingsTable body = bodies.table(role);
  body.require_known({"tool", "markers", "markers_mm", "marker_interval_ms"});
  if (body.has("tool") == body.has("markers")) {
    body.refuse("tool", body.has("tool") ? "tool and markers" : "neither tool nor markers", "one of them");
  }
  if (body.has("tool")) {
    settings.tool = tool_name(body, "tool");
  } else {
    add_markers(body, role, places, settings);
  }
  return settings;
}

std::vector<BodyRole> wanted_roles(const BenchFile& bench)
{
  std::vector<BodyRole> roles = bench.leg == LegKind::rigid
                                    ? std::vector<BodyRole>{BodyRole::leg}
                                    : std::vector<BodyRole>{BodyRole::femur, BodyRole::tibia};
  if (bench.head == HeadKind::tracker) roles.push_back(BodyRole::head);
  return roles;
}

void add_bodies(const SettingsTable& root, MarkerPlaces places, BenchFile& bench)
{
  const SettingsTable bodies = root.table("body");
  bodies.require_known({"leg", "femur", "tibia", "head"});
  std::vector<std::string>& tools = bench.tracker->tools;
  for (const BodyRole role : wanted_roles(bench)) {
    const BodySettings& body =
        bench.bodies[static_cast<std::size_t>(role)].emplace(body_of(bodies, name_of(role), places));
    std::vector<std::string> names = body.markers;
    if (!body.tool.empty()) names.push_back(body.tool);
    for (const std::string& name : names) {
      if (std::find(tools.begin(), tools.end(), name) != tools.end())
        bodies.refuse(name_of(role), "the tool '" + name + "' a second time", "each tool once");
      tools.push_back(name);
    }
  }
}

/// The probe and the marker: a tool that a body has already stays that one.
void add_calibration(const SettingsTable& root, BenchFile& bench)
{
  bench.calibration = calibration_settings_of(root);
  if (!bench.calibration.is_present) return;
  std::vector<std::string>& tools = bench.tracker->tools;
  for (const std::string& name : {bench.calibration.probe, bench.calibration.marker}) {
    if (std::find(tools.begin(), tools.end(), name) == tools.end()) tools.push_back(name);
  }
}

TrackerSettings tracker_of(const SettingsTable& root)
{
  TrackerSettings settings;
  const SettingsTable tracker = root.table("tracker");
  tracker.require_known({"host", "port", "stale_after_ms", "tdata_interval_ms"});
  settings.host = tracker.text_or("host", settings.host);
  settings.port = static_cast<std::uint16_t>(tracker.whole_or("port", settings.port, {1, 65535}));
  settings.stale_after_ms = tracker.number_or("stale_after_ms", settings.stale_after_ms, {1.0, 60000.0});
  settings.tdata_interval_ms = tracker.number_or("tdata_interval_ms", 0.0, {0.0, 10000.0});
  return settings;
}

BoardSettings board_of(const SettingsTable& board, BenchFile& bench)
{
  BoardSettings settings;
  board.require_known({"port", "baud", "rate_hz", "stage_mm_per_count", "potentiometer"});
  settings.port = board.text("port");
  settings.baud = board.whole_or("baud", settings.baud, {300, 4000000});
  settings.rate_hz = board.number_or("rate_hz", settings.rate_hz, {1.0, 1000.0});
  settings.has_stage = bench.head == HeadKind::stage;
  constexpr double most_mm_per_count = 10.0;
  bench.stage_mm_per_count = board.number_or("stage_mm_per_count", bench.stage_mm_per_count,
                                             {-most_mm_per_count, most_mm_per_count});
  if (board.has("potentiometer")) {
    std::vector<std::string> names{"selected"};
    for (std::size_t k = 0; k < parameters().size(); ++k) {
      if (is_used(k, bench)) names.push_back(parameters()[k].name);
    }
    bench.potentiometer = names[board.word("potentiometer", names)];
  }
  settings.has_potentiometer = !bench.potentiometer.empty();
  return settings;
}

FilterSettings filter_of(const SettingsTable& root)
{
  FilterSettings settings;
  if (!root.has("filter")) return settings;
  const SettingsTable filter = root.table("filter");
  filter.require_known({"on", "least_cutoff_hz", "slope"});
  settings.is_on = filter.flag_or("on", settings.is_on);
  settings.least_cutoff_hz = filter.number_or("least_cutoff_hz", settings.least_cutoff_hz, {0.01, 1000.0});
  settings.slope = filter.number_or("slope", settings.slope, {0.0, 100.0});
  return settings;
}

BenchFile bench_in(const SettingsTable& root, MarkerPlaces places)
{
  BenchFile bench;
  bench.path = root.file();
  root.require_known({"title", "leg", "head", "prediction_ms", "display", "tracker", "body", "board",
                      "filter", "simulation", "calibration"});
  bench.title = root.text("title");
  bench.display = display_of(root);
  bench.leg = static_cast<LegKind>(root.word("leg", {"rigid", "two-bodies"}));
  bench.head = static_cast<HeadKind>(root.word("head", {"stage", "tracker"}));
  bench.prediction_ms = root.number_or("prediction_ms", 0.0, {0.0, 200.0});
  bench.filter = filter_of(root);
  bench.tracker = tracker_of(root);
  add_bodies(root, places, bench);
  add_calibration(root, bench);
  if (root.has("board")) bench.board = board_of(root.table("board"), bench);
  bench.simulation = simulation_of(root, bench);
  bench.simulation_address = simulation_address_of(root);
  return bench;
}

}  // namespace

const char* name_of(BodyRole role)
{
  static constexpr std::array<const char*, n_body_roles> names{"leg", "femur", "tibia", "head"};
  return names[static_cast<std::size_t>(role)];
}

std::size_t n_tools(const BodySettings& body)
{
  return body.tool.empty() ? body.markers.size() : 1;
}

std::size_t first_tool_of(const BenchFile& bench, BodyRole role)
{
  std::size_t first = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(role); ++k) {
    if (bench.bodies[k]) first += n_tools(*bench.bodies[k]);
  }
  return first;
}

BenchFile parsed_bench_file(const std::string& text, const std::string& path, MarkerPlaces places)
{
  BenchFile bench = bench_in(SettingsTable::parsed(text, path), places);
  bench.text = text;
  return bench;
}

BenchFile read_bench_file(const std::string& path, MarkerPlaces places)
{
  return parsed_bench_file(settings_file_text(path, "a bench file (schemas/bench.md)"), path, places);
}

}  // namespace vrda
