// The table [simulation] of a bench file: motion, noise and faults of the simulated tracker and board.
#include "bench/bench_file.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "bench/calibration_file.hpp"
#include "core/schema.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/frames.hpp"

namespace vrda::bench {
namespace {

bench::SimulatedBody simulated_body(const BodySettings& settings, const char* name)
{
  bench::SimulatedBody body;
  // A body of markers has no tool; occlusions refer to it by its role name.
  body.tool = settings.tool.empty() ? name : settings.tool;
  body.markers_mm = settings.markers_body_mm;
  return body;
}

void add_bodies(const BenchFile& bench, bench::SimulationScript& script)
{
  const auto body = [&](BodyRole role) {
    return simulated_body(*bench.bodies[static_cast<std::size_t>(role)], name_of(role));
  };
  script.femur = body(bench.leg == LegKind::rigid ? BodyRole::leg : BodyRole::femur);
  if (bench.leg == LegKind::two_bodies) {
    script.tibia = body(BodyRole::tibia);
  } else {
    script.tibia.tool = "tibia, not tracked";
  }
  if (bench.head == HeadKind::tracker) script.head = body(BodyRole::head);
  for (const std::optional<BodySettings>& settings : bench.bodies) {
    if (settings && settings->marker_interval_ms > 0.0)
      script.firing_interval_ms = settings->marker_interval_ms;
  }
}

void add_paths(const core::DocumentValue& table, bench::SimulationScript& script)
{
  script.is_looped = core::flag_at(table, "loop");
  script.leg.clear();
  for (const std::vector<double>& row : core::rows_at(table, "leg"))
    script.leg.push_back({row[0], row[1], row[2]});
  script.stage.clear();
  for (const std::vector<double>& row : core::rows_at(table, "stage"))
    script.stage.push_back({row[0], row[1]});
  script.potentiometer.clear();
  for (const std::vector<double>& row : core::rows_at(table, "potentiometer"))
    script.potentiometer.push_back({row[0], row[1]});
}

void add_noise(const core::DocumentValue& table, bench::SimulationScript& script)
{
  script.rate_hz = core::number_at(table, "rate_hz");
  script.jitter_ms = core::number_at(table, "jitter_ms");
  script.drop_rate = core::number_at(table, "drop_rate");
  script.noise_mm = core::number_at(table, "noise_mm");
  script.noise_rad = rad_from_deg(core::number_at(table, "noise_deg"));
  script.potentiometer_noise_counts = core::number_at(table, "potentiometer_noise_counts");
  script.sway_mm = core::number_at(table, "sway_mm");
  script.sway_s = core::number_at(table, "sway_s");
}

void add_faults(const core::DocumentValue& table, bench::SimulationScript& script)
{
  if (table.contains("occlusion")) script.occlusions.clear();
  for (const core::DocumentValue& item : core::list_or_empty(table, "occlusion")) {
    script.occlusions.push_back({core::text_at(item, "tool"), core::number_at(item, "from_s"),
                                 core::number_at(item, "to_s"), core::number_at(item, "every_s")});
  }
  script.clock.offset_s = core::number_at(table, "clock_offset_s");
  script.clock.drift_ppm = core::number_at(table, "clock_drift_ppm");
  for (const core::DocumentValue& item : core::list_or_empty(table, "clock_step"))
    script.clock.steps.push_back({core::number_at(item, "at_s"), core::number_at(item, "by_ms")});
}

bench::PoseParameters six_at(const core::DocumentValue& table, const char* key)
{
  const std::vector<double> v = core::numbers_at(table, key);
  return {{v[0], v[1], v[2]}, Eigen::Vector3d(v[3], v[4], v[5]) * rad_from_deg(1.0)};
}

}  // namespace

std::string simulation_address_of(const core::Document& document)
{
  const std::string key = "simulation.address", &address = core::text_at(document.root, key);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET, address.c_str(), bytes.data()) != 1 &&
      inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1)
    document.refuse_value(key, "a numeric IP address of this machine, or 0.0.0.0 for all its addresses");
  return address;
}

bench::SimulationScript simulation_of(const core::Document& document, const BenchFile& bench)
{
  const core::DocumentValue& table = core::value_at(document.root, "simulation");
  bench::SimulationScript script;
  // The knee is at the table origin; the eyes of the nominal bench are 800 mm from it.
  script.X_tracker_femur.translation().setZero();
  add_bodies(bench, script);
  // The default occlusion refers to the tibia by the default name; a rigid leg has no tracked tibia.
  for (bench::Occlusion& occlusion : script.occlusions) occlusion.tool = script.tibia.tool;
  if (bench.leg == LegKind::rigid) script.occlusions.clear();
  script.X_tracker_head = bench::pose_of(nominal_calibration(bench).X_table_eyes);
  script.seed = static_cast<std::uint64_t>(core::integer_at(table, "seed"));
  script.side = side_named(core::text_at(table, "side"));
  if (table.contains("femur")) script.X_tracker_femur = bench::pose_of(six_at(table, "femur"));
  add_noise(table, script);
  add_paths(table, script);
  add_faults(table, script);
  bench::require_usable(script, document.file);
  return script;
}

namespace {

/// Throws InputError if the rectangles do not determine an eyepoint.
std::vector<CalibrationRectangle> rectangles_of(const core::Document& document, int repeats)
{
  std::vector<CalibrationRectangle> rectangles;
  std::set<double> depths_mm;
  for (const std::vector<double>& row : core::rows_at(document.root, "calibration.rectangles")) {
    rectangles.push_back({row[0], row[1]});
    depths_mm.insert(row[1]);
  }
  if (*depths_mm.rbegin() - *depths_mm.begin() < least_depth_range_mm) {
    document.refuse("calibration.rectangles", "one depth, " + shortest_decimal(*depths_mm.begin()) + " mm",
                    "two depths or more, " + shortest_decimal(least_depth_range_mm) +
                        " mm apart; one depth does not determine the distance of the eye");
  }
  const std::size_t n_marks = rectangles.size() * static_cast<std::size_t>(repeats);
  if (n_marks < least_rectangle_marks) {
    document.refuse(
        "calibration.rectangle_repeats",
        std::to_string(n_marks) + " alignments of " + std::to_string(rectangles.size()) + " rectangles",
        std::to_string(least_rectangle_marks) +
            " alignments or more for each eye; add repeats or rectangles");
  }
  return rectangles;
}

/// Throws InputError if the nodes of a grid are too few for the marks of a distortion.
void require_nodes(const core::Document& document, const CalibrationSettings& settings)
{
  const int n_nodes = settings.grid_columns * settings.grid_rows;
  if (settings.is_grid_adjusted || n_nodes >= static_cast<int>(least_grid_marks)) return;
  document.refuse(
      "calibration.grid",
      std::to_string(settings.grid_columns) + " by " + std::to_string(settings.grid_rows) + " nodes",
      std::to_string(least_grid_marks) + " nodes or more");
}

/// Converts a list of tables with unique names by `item_of`.
template <typename Item, typename ItemOf>
std::vector<Item> named_items(const core::Document& document, const std::string& key, ItemOf item_of)
{
  std::vector<Item> items;
  std::set<std::string> names;
  for (const core::DocumentValue& value : core::list_or_empty(document.root, key)) {
    const std::string& name = core::text_at(value, "name");
    if (!names.insert(name).second) {
      document.refuse(key + "." + std::to_string(items.size()) + ".name", "'" + name + "' twice",
                      "a unique name");
    }
    items.push_back(item_of(value, name));
  }
  return items;
}

std::vector<CalibrationPoint> points_of(const core::Document& document, const std::string& key)
{
  return named_items<CalibrationPoint>(
      document, key, [](const core::DocumentValue& value, const std::string& name) {
        return CalibrationPoint{name, core::vector3_at(value, "mm"), core::flag_at(value, "target")};
      });
}

std::vector<CalibrationLandmarks> landmarks_of(const core::Document& document)
{
  return named_items<CalibrationLandmarks>(
      document, "calibration.landmarks", [](const core::DocumentValue& value, const std::string& name) {
        return CalibrationLandmarks{name, core::number_at(value, "model_mm")};
      });
}

int whole_at(const core::DocumentValue& table, const char* key)
{
  return static_cast<int>(core::integer_at(table, key));
}

const std::string& required_short(const core::Document& document, const std::string& key,
                                  const std::string& name)
{
  if (name.size() > longest_tool_name) {
    document.refuse(
        key, "'" + name + "' of " + std::to_string(name.size()) + " bytes",
        "at most " + std::to_string(longest_tool_name) + " bytes (OpenIGTLink truncates longer names)");
  }
  return name;
}

}  // namespace

std::string tool_name(const core::Document& document, const std::string& key)
{
  return required_short(document, key, core::text_at(document.root, key));
}

std::vector<std::string> tool_names(const core::Document& document, const std::string& key)
{
  std::vector<std::string> names = core::texts_at(document.root, key);
  for (const std::string& one : names) required_short(document, key, one);
  return names;
}

CalibrationSettings calibration_settings_of(const core::Document& document)
{
  CalibrationSettings settings;
  const core::DocumentValue* table = core::find_at(document.root, "calibration");
  if (table == nullptr) return settings;
  const std::vector<double> grid = core::numbers_at(*table, "grid");
  settings.is_present = true;
  settings.edge_repeats = whole_at(*table, "edge_repeats");
  settings.screen_sd_mm = core::number_at(*table, "screen_sd_mm");
  settings.is_grid_adjusted = core::text_at(*table, "distortion") == "adjust";
  settings.grid_columns = static_cast<int>(grid[0]);
  settings.grid_rows = static_cast<int>(grid[1]);
  require_nodes(document, settings);
  settings.grid_repeats = whole_at(*table, "grid_repeats");
  settings.rectangle_repeats = whole_at(*table, "rectangle_repeats");
  settings.alignment_sd_rad = rad_from_deg(core::number_at(*table, "alignment_sd_deg"));
  settings.sight_sd_px = core::number_at(*table, "sight_sd_px");
  settings.has_pupillometer = core::flag_at(*table, "pupillometer");
  settings.pupillometer_sd_mm = core::number_at(*table, "pupillometer_sd_mm");
  settings.eye_height_sd_mm = core::number_at(*table, "eye_height_sd_mm");
  settings.rail_samples = whole_at(*table, "rail_samples");
  settings.pivot_samples = whole_at(*table, "pivot_samples");
  settings.hold_samples = whole_at(*table, "hold_samples");
  settings.bullseyes = whole_at(*table, "bullseyes");
  settings.is_model_adjusted = core::text_at(*table, "model") == "adjust";
  settings.model_repeats = whole_at(*table, "model_repeats");
  settings.rectangles = rectangles_of(document, settings.rectangle_repeats);
  settings.probe = tool_name(document, "calibration.probe");
  settings.marker = tool_name(document, "calibration.marker");
  settings.points = points_of(document, "calibration.point");
  settings.tibia_points = points_of(document, "calibration.tibia_point");
  settings.landmarks = landmarks_of(document);
  settings.bends = whole_at(*table, "bends");
  settings.bend_samples = whole_at(*table, "bend_samples");
  settings.functional = {
      core::number_at(*table, "tracker_sd_mm"), rad_from_deg(core::number_at(*table, "tracker_sd_deg")),
      core::number_at(*table, "model_sd_mm"), rad_from_deg(core::number_at(*table, "model_sd_deg"))};
  return settings;
}

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
  if (!display.contains("outputs")) return;
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
  if (display.contains("left_window"))
    settings.windows.left = window_of(document, "display.left_window", settings);
  if (display.contains("right_window"))
    settings.windows.right = window_of(document, "display.right_window", settings);
  if (view::within(settings.windows.left, settings.windows.right).width > 0) {
    document.refuse("display.right_window", "a window that overlaps display.left_window",
                    "windows that do not overlap");
  }
  settings.refresh_hz = core::number_at(display, "refresh_hz");
  if (display.contains("at")) {
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
  if (!body.contains("markers_mm")) {
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
  const bool has_tool = body->contains("tool"), has_markers = body->contains("markers");
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
  settings.has_potentiometer = board.contains("potentiometer");
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
  const bool is_webcam = tracker.is_string();
  bench.tracker = is_webcam ? webcam_of(document) : tracker_of(tracker);
  if (is_webcam) bench.camera = camera_of(document);
  add_bodies(document, places, bench);
  add_calibration(document, bench);
  if (is_webcam) require_webcam_tools(document, bench);
  if (root.contains("board")) bench.board = board_of(document, bench);
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
  return parse_bench_file(core::read_document_text(path, "a bench file (schemas/bench.md)"), path, places);
}

}  // namespace vrda::bench
