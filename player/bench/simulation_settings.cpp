// The table [simulation] of a bench file: motion, noise and faults of the simulated tracker and board.
#include <arpa/inet.h>

#include <array>

#include "bench/calibration.hpp"
#include "bench/document_parts.hpp"
#include "model/side.hpp"
#include "core/units.hpp"

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
  if (table.find("occlusion") != nullptr) script.occlusions.clear();
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
  if (table.find("femur") != nullptr) script.X_tracker_femur = bench::pose_of(six_at(table, "femur"));
  add_noise(table, script);
  add_paths(table, script);
  add_faults(table, script);
  bench::require_usable(script, document.file);
  return script;
}

}  // namespace vrda::bench
