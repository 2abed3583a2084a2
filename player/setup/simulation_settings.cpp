#include "setup/simulation_settings.hpp"

#include <arpa/inet.h>

#include <array>

#include "core/units.hpp"
#include "setup/calibration.hpp"

namespace vrda {
namespace {

constexpr double longest_s = 1e6;
constexpr std::size_t most_tables = 1000;

SimulatedBody simulated(const BodySettings& settings, const char* name)
{
  SimulatedBody body;
  // A body of markers has no tool of its own; the name stands for it in occlusions.
  body.tool = settings.tool.empty() ? name : settings.tool;
  body.markers_mm = settings.markers_body_mm;
  return body;
}

void add_bodies(const BenchFile& bench, SimulationScript& script)
{
  const auto body = [&](BodyRole role) {
    return simulated(*bench.bodies[static_cast<std::size_t>(role)], name_of(role));
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

void add_paths(const SettingsTable& table, SimulationScript& script)
{
  script.is_looped = table.flag_or("loop", script.is_looped);
  if (table.has("leg")) {
    script.leg.clear();
    for (const std::vector<double>& row : table.rows("leg", 3, {-longest_s, longest_s}))
      script.leg.push_back({row[0], row[1], row[2]});
  }
  if (table.has("stage")) {
    script.stage.clear();
    for (const std::vector<double>& row : table.rows("stage", 2, {-longest_s, longest_s}))
      script.stage.push_back({row[0], row[1]});
  }
  if (table.has("potentiometer")) {
    script.potentiometer.clear();
    for (const std::vector<double>& row : table.rows("potentiometer", 2, {-longest_s, longest_s}))
      script.potentiometer.push_back({row[0], row[1]});
  }
}

void add_troubles(const SettingsTable& table, SimulationScript& script)
{
  if (table.has("occlusion")) script.occlusions.clear();
  for (const SettingsTable& item : table.tables("occlusion", most_tables)) {
    item.require_known({"tool", "from_s", "to_s", "every_s"});
    script.occlusions.push_back({item.text("tool"), item.number("from_s", {0.0, longest_s}),
                                 item.number("to_s", {0.0, longest_s}),
                                 item.number_or("every_s", 0.0, {0.0, longest_s})});
  }
  for (const SettingsTable& item : table.tables("clock_step", most_tables)) {
    item.require_known({"at_s", "by_ms"});
    script.clock.steps.push_back({item.number("at_s", {0.0, longest_s}), item.number("by_ms", {-1e9, 1e9})});
  }
}

SixNumbers six_at(const SettingsTable& table, const char* name)
{
  const std::vector<double> v = table.numbers(name, 6, {-largest_mm, largest_mm});
  return {{v[0], v[1], v[2]}, Eigen::Vector3d(v[3], v[4], v[5]) * rad_from_deg(1.0)};
}

}  // namespace

std::string simulation_address_of(const SettingsTable& root)
{
  const std::string nobody_beyond = "127.0.0.1";
  if (!root.has("simulation")) return nobody_beyond;
  const SettingsTable table = root.table("simulation");
  const std::string address = table.text_or("address", nobody_beyond);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET, address.c_str(), bytes.data()) != 1 &&
      inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1)
    table.refuse("address", "'" + address + "'",
                 "the number of an address of this machine, or 0.0.0.0 for all");
  return address;
}

SimulationScript simulation_of(const SettingsTable& root, const BenchFile& bench)
{
  SimulationScript script;
  // The nominal bench has the eyes 800 mm from the knee, which the table's origin is in the middle of.
  script.X_tracker_femur.translation().setZero();
  add_bodies(bench, script);
  // Of the default: a tibia that nobody tracks, or that has another name, cannot be hidden.
  for (Occlusion& occlusion : script.occlusions) occlusion.tool = script.tibia.tool;
  if (bench.leg == LegKind::rigid) script.occlusions.clear();
  script.X_tracker_head = pose_of(nominal_calibration(bench).X_table_eyes);
  if (root.has("simulation")) {
    const SettingsTable table = root.table("simulation");
    table.require_known({"address",
                         "seed",
                         "side",
                         "rate_hz",
                         "jitter_ms",
                         "drop_rate",
                         "noise_mm",
                         "noise_deg",
                         "loop",
                         "leg",
                         "stage",
                         "potentiometer",
                         "potentiometer_noise_counts",
                         "femur",
                         "sway_mm",
                         "sway_s",
                         "occlusion",
                         "clock_step",
                         "clock_offset_s",
                         "clock_drift_ppm"});
    script.seed = static_cast<std::uint64_t>(table.whole_or("seed", 1, {0.0, 1e9}));
    if (table.has("side"))
      script.side = table.word("side", {"right", "left"}) == 0 ? Side::right : Side::left;
    script.rate_hz = table.number_or("rate_hz", script.rate_hz, {1.0, 1000.0});
    script.jitter_ms = table.number_or("jitter_ms", script.jitter_ms, {0.0, 1000.0});
    script.drop_rate = table.number_or("drop_rate", script.drop_rate, {0.0, 1.0});
    script.noise_mm = table.number_or("noise_mm", script.noise_mm, {0.0, 100.0});
    script.noise_deg = table.number_or("noise_deg", script.noise_deg, {0.0, 90.0});
    script.potentiometer_noise_counts =
        table.number_or("potentiometer_noise_counts", script.potentiometer_noise_counts, {0.0, 1000.0});
    if (table.has("femur")) script.X_tracker_femur = pose_of(six_at(table, "femur"));
    script.sway_mm = table.number_or("sway_mm", script.sway_mm, {0.0, 1000.0});
    script.sway_s = table.number_or("sway_s", script.sway_s, {0.1, longest_s});
    script.clock.offset_s = table.number_or("clock_offset_s", script.clock.offset_s, {0.0, 1e9});
    script.clock.drift_ppm = table.number_or("clock_drift_ppm", script.clock.drift_ppm, {-1e4, 1e4});
    add_paths(table, script);
    add_troubles(table, script);
  }
  require_usable(script, root.file());
  return script;
}

}  // namespace vrda
