#include "bench/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "support/input_error.hpp"

namespace vrda::script_test {

TEST(Script, TheDefaultIsUsable)
{
  EXPECT_NO_THROW(bench::require_usable({}, "bench.toml"));
  EXPECT_EQ(bench::tool_names({}), (std::vector<std::string>{"femur", "tibia"}));
}

TEST(Script, NamesBodiesAndMarkersInOrder)
{
  bench::SimulationScript script;
  script.femur.markers_mm.resize(2);
  script.head = bench::SimulatedBody{"head", {Eigen::Vector3d::Zero()}};
  EXPECT_EQ(bench::tool_names(script),
            (std::vector<std::string>{"femur", "femur-1", "femur-2", "tibia", "head", "head-1"}));
}

TEST(Script, EveryFieldThatMakesNoSenseIsNamed)
{
  struct Row {
    std::string field;
    std::function<void(bench::SimulationScript&)> spoil;
  };
  const std::vector<Row> rows = {
      {"jitter_ms", [](auto& s) { s.jitter_ms = 11.0; }},
      {"leg key 3", [](auto& s) { s.leg[2].time_s = s.leg[1].time_s; }},
      {"leg", [](auto& s) { s.leg.back().varus_deg = 1.0; }},
      {"potentiometer", [](auto& s) { s.potentiometer.back().value = 1.0; }},
      {"stage", [](auto& s) { s.stage.back().value = 1.0; }},
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
    bench::SimulationScript script;
    rows[i].spoil(script);
    const InputError::Facts facts =
        test::input_error([&] { bench::Simulation simulation(script, {}, "bench.toml"); });
    EXPECT_EQ(facts.file, "bench.toml");
    EXPECT_EQ(facts.field, rows[i].field);
  }
}

constexpr double rounding = 1e-12;

TEST(KeyPath, BetweenTurningPointsIsTheSmoothStep)
{
  const bench::KeyPath path({{0, 0}, {4, 90}, {8, 0}}, true);
  for (int i = 0; i <= 40; ++i) {
    const double s = i / 40.0, expected = 90.0 * s * s * (3.0 - 2.0 * s);
    EXPECT_NEAR(path.at(4.0 * s), expected, 90 * rounding);
    EXPECT_NEAR(path.at(8.0 - 4.0 * s), expected, 90 * rounding);
    EXPECT_NEAR(path.at(4.0 * s + 8.0 * 1000), expected, 1e-8);
    EXPECT_NEAR(path.at(4.0 * s - 8.0), expected, 90 * rounding);
  }
}

TEST(KeyPath, IsExactAtItsKeysAndStraightOnALine)
{
  const bench::KeyPath line({{1, 10}, {2, 20}, {4, 40}, {5, 50}}, false);
  for (const double t : {2.0, 2.5, 3.0, 3.9, 4.0}) EXPECT_NEAR(line.at(t), 10.0 * t, 50 * rounding);
  EXPECT_EQ(line.at(1.0), 10.0);
  EXPECT_EQ(line.at(-3.0), 10.0);
  EXPECT_EQ(line.at(99.0), 50.0);
  const bench::KeyPath constant({{3, 7}}, true);
  EXPECT_EQ(constant.at(0.0), 7.0);
  EXPECT_EQ(constant.at(9.0), 7.0);
}

TEST(KeyPath, NeverLeavesTheRangeBetweenTwoKeysAndHasNoCorner)
{
  const std::vector<bench::PathPoint> keys = {{0, 0}, {1, 45}, {1.2, 46}, {4, 90}, {6, 45}, {8, 0}};
  const bench::KeyPath path(keys, true);
  constexpr double step_s = 1e-3;
  double slope_before = (path.at(step_s) - path.at(0.0)) / step_s;
  int n_inside = 0;
  for (int i = 1; i < 8000; ++i) {
    const double t = i * step_s;
    const auto after = std::find_if(keys.begin() + 1, keys.end(),
                                    [&](const bench::PathPoint& key) { return key.time_s >= t; });
    const double from = (after - 1)->value, to = after->value;
    EXPECT_GE(path.at(t), std::min(from, to) - rounding * 100);
    EXPECT_LE(path.at(t), std::max(from, to) + rounding * 100);
    n_inside += path.at(t) != from && path.at(t) != to ? 1 : 0;
    // Slopes of up to 70 per second change within 0.2 s at the fastest: by less than 4 in a step with the
    // cubic's 6 (b - a) / length^2.
    const double slope = (path.at(t + step_s) - path.at(t)) / step_s;
    EXPECT_LT(std::abs(slope - slope_before), 4.0);
    slope_before = slope;
  }
  EXPECT_GT(n_inside, 7900);
}

}  // namespace vrda::script_test
