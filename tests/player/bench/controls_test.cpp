#include "bench/bench_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "bench_samples.hpp"

namespace vrda::controls_test {

class Controls : public testing::Test {
 protected:
  bench::BenchRequest press(view::Key key, bool has_shift = false)
  {
    return bench::apply_key(bench_.state, {key, has_shift, false});
  }
  std::string selected() const { return bench::parameters()[bench_.state.selected()].name; }
  double value(const char* name) const
  {
    return bench::value_of(bench_.state.values(), bench::find_parameter(name).value());
  }

  test::SmallBench bench_{test::rigid_text()};
};

TEST_F(Controls, UpAndDownGoThroughAllThatTheBenchUsesAndAround)
{
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    if (bench::is_used(k, bench_.state.bench())) used.push_back(k);
  }
  ASSERT_EQ(used.front(), bench_.state.selected());
  for (std::size_t k = 1; k <= used.size(); ++k) {
    press(view::Key::down);
    EXPECT_EQ(bench_.state.selected(), used[k % used.size()]);
  }
  press(view::Key::up);
  EXPECT_EQ(bench_.state.selected(), used.back());
}

TEST(ControlsOfATrackedLeg, ItsAnglesCannotBeSelected)
{
  test::SmallBench bench(test::two_bodies_text());
  EXPECT_EQ(bench::parameters()[bench.state.selected()].name, "prediction");
  bench::apply_key(bench.state, {view::key_of('F'), false, false});
  EXPECT_EQ(bench::parameters()[bench.state.selected()].name, "prediction");
  for (const char* name : {"flexion", "varus", "leg.shift_x", "head.turn_y"})
    EXPECT_FALSE(bench::is_used(bench::find_parameter(name).value(), bench.state.bench())) << name;
  for (const char* name : {"femur.turn_x", "tibia.shift_z", "eyes.shift_y", "table.turn_x", "right.k2"})
    EXPECT_TRUE(bench::is_used(bench::find_parameter(name).value(), bench.state.bench())) << name;
}

TEST_F(Controls, WithShiftTheyGoToAnotherKind)
{
  press(view::key_of('I'));
  press(view::Key::down, true);
  EXPECT_EQ(selected(), "image_distance");
  press(view::Key::down, true);
  EXPECT_EQ(selected(), "leg.shift_x");
  press(view::Key::down, true);
  EXPECT_EQ(selected(), "eyes.shift_x");  // neither femur nor tibia are tracked
  press(view::Key::up, true);
  EXPECT_EQ(selected().substr(0, 4), "leg.");
}

TEST_F(Controls, LeftAndRightChangeByStepsAndBackToTheSameValue)
{
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    const bench::Parameter& parameter = bench::parameters()[k];
    SCOPED_TRACE(parameter.name);
    bench_.state.select(k);
    // Away from the ends of the range, so that nothing is clamped.
    bench::set_value(
        bench_.state.values(), k,
        std::round(0.5 * (parameter.minimum + parameter.maximum) / parameter.step) * parameter.step);
    press(view::Key::right);
    press(view::Key::left);
    const double before = bench::value_of(bench_.state.values(), k);
    const auto gained = [&] { return (bench::value_of(bench_.state.values(), k) - before) / parameter.step; };
    press(view::Key::right);
    EXPECT_NEAR(gained(), 1.0, 1e-6);
    press(view::Key::right, true);
    EXPECT_NEAR(gained(), 11.0, 1e-6);
    press(view::Key::left, true);
    press(view::Key::left);
    press(view::Key::left);
    EXPECT_NEAR(gained(), -1.0, 1e-6);
    press(view::Key::right);
    EXPECT_NEAR(gained(), 0.0, 1e-9);
  }
}

TEST_F(Controls, SwitchesPredictionAndFilter)
{
  EXPECT_EQ(value("prediction"), 0.0);
  press(view::key_of('P'));
  EXPECT_EQ(value("prediction"), 30.0);
  press(view::key_of('P'));
  EXPECT_EQ(value("prediction"), 0.0);
  test::SmallBench bench("prediction_ms = 45\n" + test::rigid_text());
  bench::apply_key(bench.state, {view::key_of('P')});
  EXPECT_EQ(bench.state.values().prediction_ms, 0.0);
  bench::apply_key(bench.state, {view::key_of('P')});
  EXPECT_EQ(bench.state.values().prediction_ms, 45.0);
  EXPECT_TRUE(bench_.state.is_filtered());
  press(view::key_of('E'));
  EXPECT_FALSE(bench_.state.is_filtered());
  press(view::key_of('E'));
  EXPECT_TRUE(bench_.state.is_filtered());
}

TEST_F(Controls, TheOthersAskTheLoop)
{
  struct Row {
    view::Key key;
    bench::BenchRequest request;
  };
  for (const Row row :
       {Row{view::key_of('Z'), bench::BenchRequest::zero_stage},
        Row{view::key_of('W'), bench::BenchRequest::write_calibration},
        Row{view::key_of('T'), bench::BenchRequest::show_panel},
        Row{view::key_of('S'), bench::BenchRequest::screenshot},
        Row{view::key_of('H'), bench::BenchRequest::show_help},
        Row{view::key_of('?'), bench::BenchRequest::show_help},
        Row{view::key_of('Q'), bench::BenchRequest::quit}, Row{view::Key::escape, bench::BenchRequest::quit},
        Row{view::Key::up, bench::BenchRequest::none}, Row{view::key_of('X'), bench::BenchRequest::none},
        Row{view::Key::none, bench::BenchRequest::none}})
    EXPECT_EQ(press(row.key), row.request) << static_cast<int>(row.key);
}

}  // namespace vrda::controls_test
