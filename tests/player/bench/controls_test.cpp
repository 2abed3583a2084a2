#include "bench/controls.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bench_samples.hpp"

namespace vrda::controls_test {

class Controls : public testing::Test {
 protected:
  BenchRequest press(Key key, bool has_shift = false)
  {
    return press_key(bench_.state, {key, has_shift, false});
  }
  std::string selected() const { return parameters()[bench_.state.selected()].name; }
  double value(const char* name) const
  {
    return value_of(bench_.state.values(), parameter_named(name).value());
  }

  test::SmallBench bench_{test::rigid_text()};
};

TEST_F(Controls, LettersSelect)
{
  press(key_of('V'));
  EXPECT_EQ(selected(), "varus");
  press(key_of('I'));
  EXPECT_EQ(selected(), "eyes.distance_apart");
  press(key_of('F'));
  EXPECT_EQ(selected(), "flexion");
}

TEST_F(Controls, UpAndDownGoThroughAllThatTheBenchUsesAndAround)
{
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    if (is_used(k, bench_.state.bench())) used.push_back(k);
  }
  ASSERT_EQ(used.front(), bench_.state.selected());
  for (std::size_t k = 1; k <= used.size(); ++k) {
    press(Key::down);
    EXPECT_EQ(bench_.state.selected(), used[k % used.size()]);
  }
  press(Key::up);
  EXPECT_EQ(bench_.state.selected(), used.back());
}

TEST(ControlsOfATrackedLeg, ItsAnglesCannotBeSelected)
{
  test::SmallBench bench(test::two_bodies_text());
  EXPECT_EQ(parameters()[bench.state.selected()].name, "prediction");
  press_key(bench.state, {key_of('F'), false, false});
  EXPECT_EQ(parameters()[bench.state.selected()].name, "prediction");
  for (const char* name : {"flexion", "varus", "leg.shift_x", "head.turn_y"})
    EXPECT_FALSE(is_used(parameter_named(name).value(), bench.state.bench())) << name;
  for (const char* name : {"femur.turn_x", "tibia.shift_z", "eyes.shift_y", "table.turn_x", "right.k2"})
    EXPECT_TRUE(is_used(parameter_named(name).value(), bench.state.bench())) << name;
}

TEST_F(Controls, WithShiftTheyGoToAnotherKind)
{
  press(key_of('I'));
  press(Key::down, true);
  EXPECT_EQ(selected(), "image_distance");
  press(Key::down, true);
  EXPECT_EQ(selected(), "leg.shift_x");
  press(Key::down, true);
  EXPECT_EQ(selected(), "eyes.shift_x");  // neither femur nor tibia are tracked
  press(Key::up, true);
  EXPECT_EQ(selected().substr(0, 4), "leg.");
}

TEST_F(Controls, LeftAndRightChangeByStepsAndBackToTheSameValue)
{
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    const Parameter& parameter = parameters()[k];
    SCOPED_TRACE(parameter.name);
    bench_.state.select(k);
    // Away from the ends of the range, so that nothing is clamped.
    set_value(bench_.state.values(), k,
              std::round(0.5 * (parameter.least + parameter.most) / parameter.step) * parameter.step);
    press(Key::right);
    press(Key::left);
    const double before = value_of(bench_.state.values(), k);
    const auto gained = [&] { return (value_of(bench_.state.values(), k) - before) / parameter.step; };
    press(Key::right);
    EXPECT_NEAR(gained(), 1.0, 1e-6);
    press(Key::right, true);
    EXPECT_NEAR(gained(), 11.0, 1e-6);
    press(Key::left, true);
    press(Key::left);
    press(Key::left);
    EXPECT_NEAR(gained(), -1.0, 1e-6);
    press(Key::right);
    EXPECT_NEAR(gained(), 0.0, 1e-9);
  }
}

TEST_F(Controls, AHundredStepsThereAndBackGiveTheSameBits)
{
  press(key_of('F'));
  press(Key::right);
  for (const char* name : {"flexion", "left.k1", "eyes.shift_y", "left.pixel_aspect"}) {
    bench_.state.select(parameter_named(name).value());
    press(Key::right);
    const double before = value(name);
    for (int k = 0; k < 100; ++k) press(Key::right);
    for (int k = 0; k < 100; ++k) press(Key::left);
    EXPECT_EQ(value(name), before) << name;
  }
}

TEST_F(Controls, SwitchesPredictionAndFilter)
{
  EXPECT_EQ(value("prediction"), 0.0);
  press(key_of('P'));
  EXPECT_EQ(value("prediction"), 30.0);
  press(key_of('P'));
  EXPECT_EQ(value("prediction"), 0.0);
  test::SmallBench bench("prediction_ms = 45\n" + test::rigid_text());
  press_key(bench.state, {key_of('P')});
  EXPECT_EQ(bench.state.values().prediction_ms, 0.0);
  press_key(bench.state, {key_of('P')});
  EXPECT_EQ(bench.state.values().prediction_ms, 45.0);
  EXPECT_TRUE(bench_.state.is_filtered());
  press(key_of('E'));
  EXPECT_FALSE(bench_.state.is_filtered());
  press(key_of('E'));
  EXPECT_TRUE(bench_.state.is_filtered());
}

TEST_F(Controls, TheOthersAskTheLoop)
{
  struct Row {
    Key key;
    BenchRequest request;
  };
  for (const Row row :
       {Row{key_of('Z'), BenchRequest::zero_stage}, Row{key_of('W'), BenchRequest::write_calibration},
        Row{key_of('T'), BenchRequest::show_panel}, Row{key_of('S'), BenchRequest::screenshot},
        Row{key_of('H'), BenchRequest::show_help}, Row{key_of('?'), BenchRequest::show_help},
        Row{key_of('Q'), BenchRequest::quit}, Row{Key::escape, BenchRequest::quit},
        Row{Key::up, BenchRequest::none}, Row{key_of('X'), BenchRequest::none},
        Row{Key::none, BenchRequest::none}})
    EXPECT_EQ(press(row.key), row.request) << static_cast<int>(row.key);
}

TEST_F(Controls, EveryKeyOfTheHelpIsTested)
{
  std::string keys;
  for (const HelpLine& line : bench_key_lines()) keys += std::string(line.keys) + "; ";
  EXPECT_EQ(keys, "Up, Down; Left, Right; F, V, I; P; E; Z; W; T; S; H or ?; Q or Esc; ");
}

TEST_F(Controls, ParametersAreToldWithTheirUnit)
{
  set_value(bench_.state.values(), 0, 35.5);
  EXPECT_EQ(parameter_text(bench_.state, 0), "flexion 35.5 deg");
  const std::size_t k1 = parameter_named("left.k1").value();
  set_value(bench_.state.values(), k1, 0.021);
  EXPECT_EQ(parameter_text(bench_.state, k1), "left.k1 0.021");
}

}  // namespace vrda::controls_test
