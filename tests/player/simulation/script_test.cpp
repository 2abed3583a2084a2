#include "simulation/script.hpp"

#include <gtest/gtest.h>

#include <functional>

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
      {"jitter_ms", [](auto& s) { s.jitter_ms = 11.0; }},
      {"leg key 3", [](auto& s) { s.leg[2].time_s = s.leg[1].time_s; }},
      {"leg", [](auto& s) { s.leg.back().varus_deg = 1.0; }},
      {"potentiometer", [](auto& s) { s.potentiometer.back().count = 1.0; }},
      {"stage", [](auto& s) { s.stage.back().position_mm = 1.0; }},
      {"tool", [](auto& s) { s.tibia.tool = "femur"; }},
      {"occlusion tool", [](auto& s) { s.occlusions[0].tool = "patella"; }},
      {"occlusion to_s", [](auto& s) { s.occlusions[0].to_s = 4.0; }},
      {"occlusion every_s", [](auto& s) { s.occlusions[0].every_s = 0.5; }},
      {"clock step at_s",
       [](auto& s) {
         s.clock.steps = {{2.0, 1.0}, {1.0, 1.0}};
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
