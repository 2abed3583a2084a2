#include "bench/bench_file.hpp"

#include <algorithm>
#include <filesystem>

#include "bench/document_parts.hpp"
#include "bench/parameters.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "core/schema.hpp"

namespace vrda::bench {

const core::DocumentSchema& bench_schema();  // schemas/bench.schema.json

namespace {

view::Viewport window_of(const core::Document& document, const std::string& key,
                           const DisplaySettings& settings)
{
  const std::vector<double> v = core::numbers_at(document.root, key);
  const view::Viewport window{static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]),
                                static_cast<int>(v[3])};
  const bool fits = window.width > 0 && window.height > 0 && window.x + window.width <= settings.width &&
                    window.y + window.height <= settings.height;
  if (!fits) {
    document.refuse(key, "a rectangle that reaches beyond the frame buffer, or has no size",
                    "x, y, width, height in whole pixels within " + std::to_string(settings.width) + " x " +
                        std::to_string(settings.height));
  }
  return window;
}

void add_outputs(const core::Document& document, const core::DocumentValue& display,
                 DisplaySettings& settings)
{
  if (display.find("outputs") == nullptr) return;
  settings.outputs = core::texts_at(display, "outputs");
  if (settings.at)
    document.refuse("display.outputs", "outputs and at", "one of them, because outputs have positions");
  const bool is_two = settings.layout == view::Layout::two_outputs;
  if (is_two != (settings.outputs.size() == 2)) {
    document.refuse("display.outputs", std::to_string(settings.outputs.size()) + " names",
                    is_two ? "two names with the layout two-outputs, of the left and the right eye"
                           : "one name, or the layout two-outputs");
  }
}

DisplaySettings display_of(const core::Document& document)
{
  const core::DocumentValue& display = core::value_at(document.root, "display");
  DisplaySettings settings;
  settings.width = static_cast<int>(core::integer_at(display, "width"));
  settings.height = static_cast<int>(core::integer_at(display, "height"));
  settings.layout = view::layout_named(core::text_at(display, "layout")).value();
  settings.windows = view::eye_windows(settings.layout, settings.width, settings.height, document.file);
  if (display.find("left_window") != nullptr)
    settings.windows.left = window_of(document, "display.left_window", settings);
  if (display.find("right_window") != nullptr)
    settings.windows.right = window_of(document, "display.right_window", settings);
  if (view::within(settings.windows.left, settings.windows.right).width > 0) {
    document.refuse("display.right_window", "a window that overlaps display.left_window",
                    "windows that do not overlap");
  }
  settings.refresh_hz = core::number_at(display, "refresh_hz");
  if (display.find("at") != nullptr) {
    // Negative positions are valid: an output may be left of or above the first one.
    const std::vector<double> at = core::numbers_at(display, "at");
    settings.at = {static_cast<int>(at[0]), static_cast<int>(at[1])};
  }
  add_outputs(document, display, settings);
  settings.reflection = {core::flag_at(display, "mirror"), core::flag_at(display, "flip")};
  settings.is_half_width = core::flag_at(display, "half_width");
  if (settings.is_half_width && settings.layout != view::Layout::side_by_side)
    document.refuse("display.half_width", "true with another layout", "the layout side-by-side");
  return settings;
}

void add_markers(const core::Document& document, const std::string& role, MarkerPositions places,
                 BodySettings& settings)
{
  const std::string key = "body." + role;
  const core::DocumentValue& body = core::value_at(document.root, key);
  settings.markers = tool_names(document, key + ".markers");
  settings.marker_interval_ms = core::number_at(body, "marker_interval_ms");
  if (body.find("markers_mm") == nullptr) {
    if (places == MarkerPositions::optional) return;
    document.refuse(key + ".markers_mm", "nothing",
                    "x, y, z of each marker (measure them with vrda-player body " + role + ")");
  }
  const std::vector<double> flat = core::numbers_at(body, "markers_mm");
  if (flat.size() != 3 * settings.markers.size()) {
    document.refuse_value(key + ".markers_mm",
                          std::to_string(3 * settings.markers.size()) + " numbers: x, y, z of each marker");
  }
  for (std::size_t k = 0; k < flat.size(); k += 3)
    settings.markers_body_mm.emplace_back(flat[k], flat[k + 1], flat[k + 2]);
}

BodySettings body_of(const core::Document& document, const std::string& role, MarkerPositions places)
{
  const std::string key = "body." + role;
  const core::DocumentValue* body = core::find_at(document.root, key);
  if (body == nullptr) document.refuse(key, "nothing", "a table with tool or with markers and markers_mm");
  const bool has_tool = body->find("tool") != nullptr, has_markers = body->find("markers") != nullptr;
  if (has_tool == has_markers) {
    document.refuse(key + ".tool", has_tool ? "tool and markers" : "neither tool nor markers", "one of them");
  }
  BodySettings settings;
  if (has_tool) {
    settings.tool = tool_name(document, key + ".tool");
  } else {
    add_markers(document, role, places, settings);
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

void add_bodies(const core::Document& document, MarkerPositions places, BenchFile& bench)
{
  std::vector<std::string>& tools = bench.tracker->tools;
  for (const BodyRole role : wanted_roles(bench)) {
    const BodySettings& body =
        bench.bodies[static_cast<std::size_t>(role)].emplace(body_of(document, name_of(role), places));
    std::vector<std::string> names = body.markers;
    if (!body.tool.empty()) names.push_back(body.tool);
    for (const std::string& name : names) {
      if (std::ranges::find(tools, name) != tools.end()) {
        document.refuse(std::string("body.") + name_of(role), "the tool '" + name + "' twice",
                        "each tool only once");
      }
      tools.push_back(name);
    }
  }
}

/// Adds the tools of probe and marker unless a body already uses them.
void add_calibration(const core::Document& document, BenchFile& bench)
{
  bench.calibration = calibration_settings_of(document);
  if (!bench.calibration.is_present) return;
  std::vector<std::string>& tools = bench.tracker->tools;
  for (const std::string& name : {bench.calibration.probe, bench.calibration.marker}) {
    if (std::ranges::find(tools, name) == tools.end()) tools.push_back(name);
  }
}

bench::TrackerSettings tracker_of(const core::DocumentValue& tracker)
{
  bench::TrackerSettings settings;
  settings.host = core::text_at(tracker, "host");
  settings.port = static_cast<std::uint16_t>(core::integer_at(tracker, "port"));
  settings.stale_after_ms = core::number_at(tracker, "stale_after_ms");
  settings.tdata_interval_ms = core::number_at(tracker, "tdata_interval_ms");
  return settings;
}

/// A webcam is read by a program of its own, with this bench file.
bench::TrackerSettings webcam_of(const core::Document& document)
{
  bench::TrackerSettings settings;
  settings.program = {"vrda-webcam", "track", document.file};
  settings.stale_after_ms = core::number_at(document.root, "camera.stale_after_ms");
  return settings;
}

CameraSettings camera_of(const core::Document& document)
{
  const core::DocumentValue& camera = core::value_at(document.root, "camera");
  CameraSettings settings;
  settings.device = core::text_at(camera, "device");
  settings.width = static_cast<int>(core::integer_at(camera, "width"));
  settings.height = static_cast<int>(core::integer_at(camera, "height"));
  settings.rate_hz = core::number_at(camera, "rate_hz");
  settings.calibration =
      std::filesystem::path(document.file).parent_path() / core::text_at(camera, "calibration");
  settings.marker_mm = core::number_at(camera, "marker_mm");
  settings.fold_rad = rad_from_deg(core::number_at(camera, "fold_deg"));
  return settings;
}

/// The dictionary has four markers for each of 12 bodies.
void require_webcam_tools(const core::Document& document, const BenchFile& bench)
{
  constexpr std::size_t most = 12;
  for (std::size_t k = 0; k < n_body_roles; ++k) {
    if (bench.bodies[k] && !bench.bodies[k]->markers.empty())
      document.refuse(std::string("body.") + name_of(static_cast<BodyRole>(k)) + ".markers",
                      "single markers with tracker = \"aruco\"", "a tool: the name of a printed body");
  }
  if (bench.tracker->tools.size() > most)
    document.refuse("tracker", std::to_string(bench.tracker->tools.size()) + " bodies",
                    "at most 12 with \"aruco\"");
}

void require_parameter(const core::Document& document, const BenchFile& bench)
{
  std::vector<std::string> names{"selected"};
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    if (is_used(k, bench)) names.push_back(parameters()[k].name);
  }
  if (std::ranges::find(names, bench.potentiometer) == names.end())
    document.refuse_value("board.potentiometer", "one of " + join_alternatives(names));
}

bench::BoardSettings board_of(const core::Document& document, BenchFile& bench)
{
  const core::DocumentValue& board = core::value_at(document.root, "board");
  bench::BoardSettings settings;
  settings.port = core::text_at(board, "port");
  settings.baud = static_cast<int>(core::integer_at(board, "baud"));
  settings.rate_hz = core::number_at(board, "rate_hz");
  settings.has_stage = bench.head == HeadKind::stage;
  settings.has_potentiometer = board.find("potentiometer") != nullptr;
  bench.stage_mm_per_count = core::number_at(board, "stage_mm_per_count");
  bench.potentiometer = core::text_or_empty(board, "potentiometer");
  if (settings.has_potentiometer) require_parameter(document, bench);
  return settings;
}

BenchFile bench_in(const core::Document& document, MarkerPositions places)
{
  const core::DocumentValue& root = document.root;
  BenchFile bench;
  bench.path = document.file;
  bench.title = core::text_at(root, "title");
  bench.display = display_of(document);
  bench.leg = core::text_at(root, "leg") == "rigid" ? LegKind::rigid : LegKind::two_bodies;
  bench.head = core::text_at(root, "head") == "stage" ? HeadKind::stage : HeadKind::tracker;
  bench.prediction_ms = core::number_at(root, "prediction_ms");
  bench.filter = {core::flag_at(root, "filter.on"), core::number_at(root, "filter.least_cutoff_hz"),
                  core::number_at(root, "filter.slope") * deg_from_rad(1.0)};
  const core::DocumentValue& tracker = core::value_at(root, "tracker");
  const bool is_webcam = tracker.text() != nullptr;
  bench.tracker = is_webcam ? webcam_of(document) : tracker_of(tracker);
  if (is_webcam) bench.camera = camera_of(document);
  add_bodies(document, places, bench);
  add_calibration(document, bench);
  if (is_webcam) require_webcam_tools(document, bench);
  if (root.find("board") != nullptr) bench.board = board_of(document, bench);
  bench.simulation = simulation_of(document, bench);
  bench.simulation_address = simulation_address_of(document);
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

std::size_t first_tool_index(const BenchFile& bench, BodyRole role)
{
  std::size_t first = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(role); ++k) {
    if (bench.bodies[k]) first += n_tools(*bench.bodies[k]);
  }
  return first;
}

BenchFile parse_bench_file(const std::string& text, const std::string& path, MarkerPositions places)
{
  BenchFile bench = bench_in(bench_schema().read(text, path), places);
  bench.text = text;
  return bench;
}

BenchFile read_bench_file(const std::string& path, MarkerPositions places)
{
  return parse_bench_file(core::read_document_text(path, "a bench file (schemas/bench.md)"), path,
                          places);
}

}  // namespace vrda::bench
