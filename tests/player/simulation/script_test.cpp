#include "simulation/script.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "simulation/simulation.hpp"
#include "support/input_error.hpp"

namespace vrda::script_test {

TEST(Script, TheDefaultIsUsable)
{
  EXPECT_NO_THROW(require_usable({}, "bench.toml"));
  EXPECT_EQ(tool_names({}), (std::vector<std::string>{"femur", "tibia"}));
}

TEST(Script, NamesBodiesAndMarkersInOrder)
{
  SimulationScript script;
  script.femur.markers_mm.resize(2);
  script.head = SimulatedBody{"head", Pose::Identity(), {Eigen::Vector3d::Zero()}};
  EXPECT_EQ(tool_names(script),
            (std::vector<std::string>{"femur", "femur-1", "femur-2", "tibia", "head", "head-1"}));
}

TEST(Script, EveryFieldThatMakesNoSenseIsNamed)
{
  struct Row {
    std::string field;
    std::function<void(SimulationScript&)> spoil;
  };
  const std::vector<Row> rows = {
      {"rate_hz", [](auto& s) { s.rate_hz = 0.0; }},
      {"rate_hz", [](auto& s) { s.rate_hz = std::numeric_limits<double>::quiet_NaN(); }},
      {"jitter_ms", [](auto& s) { s.jitter_ms = 11.0; }},
      {"drop_rate", [](auto& s) { s.drop_rate = 1.1; }},
      {"noise_mm", [](auto& s) { s.noise_mm = -0.1; }},
      {"noise_deg", [](auto& s) { s.noise_deg = 30.0; }},
      {"potentiometer_noise_counts", [](auto& s) { s.potentiometer_noise_counts = -1.0; }},
      {"sway_mm", [](auto& s) { s.sway_mm = -1.0; }},
      {"sway_s", [](auto& s) { s.sway_s = 0.0; }},
      {"firing_interval_ms", [](auto& s) { s.firing_interval_ms = -1.0; }},
      {"leg", [](auto& s) { s.leg.clear(); }},
      {"leg key 3", [](auto& s) { s.leg[2].time_s = s.leg[1].time_s; }},
      {"leg", [](auto& s) { s.leg.back().varus_deg = 1.0; }},
      {"leg time_s", [](auto& s) { s.leg.front().time_s = -1.0; }},
      {"leg flexion_deg", [](auto& s) { s.leg[1].flexion_deg = 200.0; }},
      {"leg varus_deg", [](auto& s) { s.leg[1].varus_deg = -90.0; }},
      {"stage", [](auto& s) { s.stage.back().position_mm = 1.0; }},
      {"stage time_s", [](auto& s) { s.stage.back().time_s = 1e7; }},
      {"stage position_mm", [](auto& s) { s.stage[1].position_mm = 2000.0; }},
      {"potentiometer", [](auto& s) { s.potentiometer.clear(); }},
      {"potentiometer time_s", [](auto& s) { s.potentiometer.front().time_s = -1.0; }},
      {"potentiometer count", [](auto& s) { s.potentiometer[1].count = 1024.0; }},
      {"tool", [](auto& s) { s.tibia.tool.clear(); }},
      {"tool", [](auto& s) { s.tibia.tool = "femur"; }},
      {"occlusion tool", [](auto& s) { s.occlusions[0].tool = "patella"; }},
      {"occlusion from_s", [](auto& s) { s.occlusions[0].from_s = -1.0; }},
      {"occlusion to_s", [](auto& s) { s.occlusions[0].to_s = 4.0; }},
      {"occlusion every_s", [](auto& s) { s.occlusions[0].every_s = 0.5; }},
      {"clock offset_s", [](auto& s) { s.clock.offset_s = 0.0; }},
      {"clock drift_ppm", [](auto& s) { s.clock.drift_ppm = 2e5; }},
      {"clock step at_s",
       [](auto& s) {
         s.clock.steps = {{2.0, 1.0}, {1.0, 1.0}};
       }},
      {"clock step by_ms",
       [](auto& s) {
         s.clock.steps = {{2.0, 1e10}};
       }},
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE(i);
    SimulationScript script;
    rows[i].spoil(script);
    const InputError::Facts facts =
        test::input_error([&] { Simulation simulation(script, {}, "bench.toml"); });
    EXPECT_EQ(facts.file, "bench.toml");
    EXPECT_EQ(facts.field, rows[i].field);
  }
}

}  // namespace vrda::script_test
