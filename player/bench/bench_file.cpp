// Reads bench files (TOML, schemas/bench.schema.json); angles in degrees in the file.

#include <arpa/inet.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "bench/calibration_file.hpp"
#include "bench/toml_table.hpp"
#include "core/schema.hpp"
#include "core/text.hpp"
#include "model/frames.hpp"

namespace vrda::bench {

const core::DocumentSchema& bench_schema();  // schemas/bench.schema.json

namespace {

void add_bodies(const BenchFile& bench, SimulationScript& script)
{
  const auto body = [&](BodyRole role) -> SimulatedBody {
    const BodySettings& settings = *bench.bodies[role];
    // A body of markers has no tool; occlusions refer to it by its role name.
    return {settings.tool.empty() ? name_of(role) : settings.tool, settings.markers_body_mm};
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

std::vector<PathPoint> path_at(const core::DocumentValue& table, const char* key)
{
  std::vector<PathPoint> path;
  for (const std::vector<double>& row : core::rows_at(table, key)) path.push_back({row[0], row[1]});
  return path;
}

void add_motion(const core::DocumentValue& table, SimulationScript& script)
{
  const TableReader read(table);
  std::string side;
  read("seed", script.seed);
  read("side", side);
  script.side = side_named(side);
  read("rate_hz", script.rate_hz);
  read("jitter_ms", script.jitter_ms);
  read("drop_rate", script.drop_rate);
  read("noise_mm", script.noise_mm);
  read.degrees("noise_deg", script.noise_rad);
  read("potentiometer_noise_counts", script.potentiometer_noise_counts);
  read("sway_mm", script.sway_mm);
  read("sway_s", script.sway_s);
  read("loop", script.is_looped);
  script.leg.clear();
  for (const std::vector<double>& row : core::rows_at(table, "leg"))
    script.leg.push_back({row[0], row[1], row[2]});
  script.stage = path_at(table, "stage");
  script.potentiometer = path_at(table, "potentiometer");
}

void add_faults(const core::DocumentValue& table, SimulationScript& script)
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

/// Numeric listening address of the simulated tracker; loopback unless the file sets another.
std::string simulation_address_of(const core::Document& document)
{
  const std::string key = "simulation.address", &address = core::text_at(document.root, key);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET, address.c_str(), bytes.data()) != 1 &&
      inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1)
    document.refuse_value(key, "a numeric IP address of this machine, or 0.0.0.0 for all its addresses");
  return address;
}

/// Script of the simulated devices: bodies and markers of `bench`, paths and noise of the schema-checked
/// file. Throws InputError with file and key.
SimulationScript simulation_of(const core::Document& document, const BenchFile& bench)
{
  const core::DocumentValue& table = core::value_at(document.root, "simulation");
  SimulationScript script;
  // The knee is at the table origin; the eyes of the nominal bench are 800 mm from it.
  script.X_tracker_femur.translation().setZero();
  add_bodies(bench, script);
  // The default occlusion refers to the tibia by the default name; a rigid leg has no tracked tibia.
  for (Occlusion& occlusion : script.occlusions) occlusion.tool = script.tibia.tool;
  if (bench.leg == LegKind::rigid) script.occlusions.clear();
  script.X_tracker_head = pose_of(nominal_calibration(bench).X_table_eyes);
  if (table.contains("femur"))
    script.X_tracker_femur = pose_of(pose_parameters_of(core::numbers_at(table, "femur")));
  add_motion(table, script);
  add_faults(table, script);
  require_usable(script, document.file);
  return script;
}

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

/// Length of the device name field of an OpenIGTLink message, bytes.
constexpr std::size_t longest_tool_name = 20;

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
  const TableReader read(*table);
  std::vector<double> grid;
  settings.is_present = true;
  read("edge_repeats", settings.edge_repeats);
  read("screen_sd_mm", settings.screen_sd_mm);
  settings.is_grid_adjusted = core::text_at(*table, "distortion") == "adjust";
  read("grid", grid);
  settings.grid_columns = static_cast<int>(grid[0]);
  settings.grid_rows = static_cast<int>(grid[1]);
  require_nodes(document, settings);
  read("grid_repeats", settings.grid_repeats);
  read("rectangle_repeats", settings.rectangle_repeats);
  read.degrees("alignment_sd_deg", settings.alignment_sd_rad);
  read("sight_sd_px", settings.sight_sd_px);
  read("pupillometer", settings.has_pupillometer);
  read("pupillometer_sd_mm", settings.pupillometer_sd_mm);
  read("eye_height_sd_mm", settings.eye_height_sd_mm);
  read("rail_samples", settings.rail_samples);
  read("pivot_samples", settings.pivot_samples);
  read("hold_samples", settings.hold_samples);
  read("bullseyes", settings.bullseyes);
  settings.is_model_adjusted = core::text_at(*table, "model") == "adjust";
  read("model_repeats", settings.model_repeats);
  settings.rectangles = rectangles_of(document, settings.rectangle_repeats);
  settings.probe = tool_name(document, "calibration.probe");
  settings.marker = tool_name(document, "calibration.marker");
  settings.points = points_of(document, "calibration.point");
  settings.tibia_points = points_of(document, "calibration.tibia_point");
  settings.landmarks = landmarks_of(document);
  read("bends", settings.bends);
  read("bend_samples", settings.bend_samples);
  read("tracker_sd_mm", settings.functional.tracker_sd_mm);
  read.degrees("tracker_sd_deg", settings.functional.tracker_sd_rad);
  read("model_sd_mm", settings.functional.model_sd_mm);
  read.degrees("model_sd_deg", settings.functional.model_sd_rad);
  return settings;
}

void require_window(const core::Document& document, const std::string& key, const view::Viewport& window,
                    const DisplaySettings& settings)
{
  const bool fits = window.width > 0 && window.height > 0 && window.x + window.width <= settings.width &&
                    window.y + window.height <= settings.height;
  if (!fits) {
    document.refuse(key, "a rectangle that reaches beyond the frame buffer, or has no size",
                    "x, y, width, height in whole pixels within " + std::to_string(settings.width) + " x " +
                        std::to_string(settings.height));
  }
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
  const TableReader read(display);
  DisplaySettings settings;
  std::string layout;
  std::vector<double> at;
  read("width", settings.width);
  read("height", settings.height);
  read("layout", layout);
  settings.layout = view::layout_named(layout).value();
  settings.windows = view::eye_windows(settings.layout, settings.width, settings.height, document.file);
  for (const auto& [key, window] : {std::pair{"left_window", &settings.windows.left},
                                    std::pair{"right_window", &settings.windows.right}}) {
    read.optional(key, *window);
    if (display.contains(key)) require_window(document, std::string("display.") + key, *window, settings);
  }
  if (view::within(settings.windows.left, settings.windows.right).width > 0) {
    document.refuse("display.right_window", "a window that overlaps display.left_window",
                    "windows that do not overlap");
  }
  read("refresh_hz", settings.refresh_hz);
  // Negative positions are valid: an output may be left of or above the first one.
  read.optional("at", at);
  if (!at.empty()) settings.at = {static_cast<int>(at[0]), static_cast<int>(at[1])};
  add_outputs(document, display, settings);
  read("mirror", settings.reflection.is_mirrored);
  read("flip", settings.reflection.is_flipped);
  read("half_width", settings.is_half_width);
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
    const BodySettings& body = bench.bodies[role].emplace(body_of(document, name_of(role), places));
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

TrackerSettings tracker_of(const core::DocumentValue& tracker)
{
  const TableReader read(tracker);
  TrackerSettings settings;
  read("host", settings.host);
  read("port", settings.port);
  read("stale_after_ms", settings.stale_after_ms);
  read("tdata_interval_ms", settings.tdata_interval_ms);
  return settings;
}

/// A webcam is read by a program of its own, with this bench file.
TrackerSettings webcam_of(const core::Document& document)
{
  TrackerSettings settings;
  settings.program = {"vrda-webcam", "track", document.file};
  settings.stale_after_ms = core::number_at(document.root, "camera.stale_after_ms");
  return settings;
}

CameraSettings camera_of(const core::Document& document)
{
  const TableReader read(core::value_at(document.root, "camera"));
  CameraSettings settings;
  read("device", settings.device);
  read("width", settings.width);
  read("height", settings.height);
  read("rate_hz", settings.rate_hz);
  read("calibration", settings.calibration);
  settings.calibration = std::filesystem::path(document.file).parent_path() / settings.calibration;
  read("marker_mm", settings.marker_mm);
  read.degrees("fold_deg", settings.fold_rad);
  return settings;
}

/// The dictionary has four markers for each of 12 bodies.
void require_webcam_tools(const core::Document& document, const BenchFile& bench)
{
  constexpr std::size_t most = 12;
  for (const BodyRole role : body_roles) {
    if (bench.bodies[role] && !bench.bodies[role]->markers.empty())
      document.refuse(std::string("body.") + name_of(role) + ".markers",
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

BoardSettings board_of(const core::Document& document, BenchFile& bench)
{
  const core::DocumentValue& board = core::value_at(document.root, "board");
  const TableReader read(board);
  BoardSettings settings;
  read("port", settings.port);
  read("baud", settings.baud);
  read("rate_hz", settings.rate_hz);
  settings.has_stage = bench.head == HeadKind::stage;
  settings.has_potentiometer = board.contains("potentiometer");
  read("stage_mm_per_count", bench.stage_mm_per_count);
  read.optional("potentiometer", bench.potentiometer);
  if (settings.has_potentiometer) require_parameter(document, bench);
  return settings;
}

BenchFile bench_in(const core::Document& document, MarkerPositions places)
{
  const core::DocumentValue& root = document.root;
  BenchFile bench;
  bench.path = document.file;
  const TableReader read(root);
  read("title", bench.title);
  bench.display = display_of(document);
  bench.leg = core::text_at(root, "leg") == "rigid" ? LegKind::rigid : LegKind::two_bodies;
  bench.head = core::text_at(root, "head") == "stage" ? HeadKind::stage : HeadKind::tracker;
  read("prediction_ms", bench.prediction_ms);
  read("filter.on", bench.filter.is_on);
  read("filter.least_cutoff_hz", bench.filter.least_cutoff_hz);
  read("filter.slope", bench.filter.slope);
  bench.filter.slope *= deg_from_rad(1.0);
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
  return ByRole<const char*>{"leg", "femur", "tibia", "head"}[role];
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
