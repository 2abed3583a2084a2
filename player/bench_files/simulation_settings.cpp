// The table [simulation] of a bench file: motion, noise and faults of the simulated tracker and board.
#include <arpa/inet.h>

#include <array>

#include "bench_files/calibration.hpp"
#include "bench_files/document_parts.hpp"
#include "core/side.hpp"
#include "core/units.hpp"

namespace vrda::bench_files {
namespace {

simulation::SimulatedBody simulated_body(const BodySettings& settings, const char* name)
{
  simulation::SimulatedBody body;
  // A body of markers has no tool; occlusions refer to it by its role name.
  body.tool = settings.tool.empty() ? name : settings.tool;
  body.markers_mm = settings.markers_body_mm;
  return body;
}

void add_bodies(const BenchFile& bench, simulation::SimulationScript& script)
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

void add_paths(const documents::DocumentValue& table, simulation::SimulationScript& script)
{
  script.is_looped = documents::flag_at(table, "loop");
  script.leg.clear();
  for (const std::vector<double>& row : documents::rows_at(table, "leg"))
    script.leg.push_back({row[0], row[1], row[2]});
  script.stage.clear();
  for (const std::vector<double>& row : documents::rows_at(table, "stage"))
    script.stage.push_back({row[0], row[1]});
  script.potentiometer.clear();
  for (const std::vector<double>& row : documents::rows_at(table, "potentiometer"))
    script.potentiometer.push_back({row[0], row[1]});
}

void add_noise(const documents::DocumentValue& table, simulation::SimulationScript& script)
{
  script.rate_hz = documents::number_at(table, "rate_hz");
  script.jitter_ms = documents::number_at(table, "jitter_ms");
  script.drop_rate = documents::number_at(table, "drop_rate");
  script.noise_mm = documents::number_at(table, "noise_mm");
  script.noise_rad = rad_from_deg(documents::number_at(table, "noise_deg"));
  script.potentiometer_noise_counts = documents::number_at(table, "potentiometer_noise_counts");
  script.sway_mm = documents::number_at(table, "sway_mm");
  script.sway_s = documents::number_at(table, "sway_s");
}

void add_faults(const documents::DocumentValue& table, simulation::SimulationScript& script)
{
  if (table.find("occlusion") != nullptr) script.occlusions.clear();
  for (const documents::DocumentValue& item : documents::list_or_empty(table, "occlusion")) {
    script.occlusions.push_back({documents::text_at(item, "tool"), documents::number_at(item, "from_s"),
                                 documents::number_at(item, "to_s"), documents::number_at(item, "every_s")});
  }
  script.clock.offset_s = documents::number_at(table, "clock_offset_s");
  script.clock.drift_ppm = documents::number_at(table, "clock_drift_ppm");
  for (const documents::DocumentValue& item : documents::list_or_empty(table, "clock_step"))
    script.clock.steps.push_back({documents::number_at(item, "at_s"), documents::number_at(item, "by_ms")});
}

tracking::PoseParameters six_at(const documents::DocumentValue& table, const char* key)
{
  const std::vector<double> v = documents::numbers_at(table, key);
  return {{v[0], v[1], v[2]}, Eigen::Vector3d(v[3], v[4], v[5]) * rad_from_deg(1.0)};
}

}  // namespace

std::string simulation_address_of(const documents::Document& document)
{
  const std::string key = "simulation.address", &address = documents::text_at(document.root, key);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET, address.c_str(), bytes.data()) != 1 &&
      inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1)
    document.refuse_value(key, "a numeric IP address of this machine, or 0.0.0.0 for all its addresses");
  return address;
}

simulation::SimulationScript simulation_of(const documents::Document& document, const BenchFile& bench)
{
  const documents::DocumentValue& table = documents::value_at(document.root, "simulation");
  simulation::SimulationScript script;
  // The knee is at the table origin; the eyes of the nominal bench are 800 mm from it.
  script.X_tracker_femur.translation().setZero();
  add_bodies(bench, script);
  // The default occlusion refers to the tibia by the default name; a rigid leg has no tracked tibia.
  for (simulation::Occlusion& occlusion : script.occlusions) occlusion.tool = script.tibia.tool;
  if (bench.leg == LegKind::rigid) script.occlusions.clear();
  script.X_tracker_head = tracking::pose_of(nominal_calibration(bench).X_table_eyes);
  script.seed = static_cast<std::uint64_t>(documents::integer_at(table, "seed"));
  script.side = side_named(documents::text_at(table, "side"));
  if (table.find("femur") != nullptr) script.X_tracker_femur = tracking::pose_of(six_at(table, "femur"));
  add_noise(table, script);
  add_paths(table, script);
  add_faults(table, script);
  simulation::require_usable(script, document.file);
  return script;
}

}  // namespace vrda::bench_files
