#include "setup/parameters.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "bench_texts.hpp"

namespace vrda::parameters_test {

/// Of an angle converted to degrees and back.
constexpr double rounding = 1e-10;

BenchValues nominal_values()
{
  BenchValues values;
  values.calibration = nominal_calibration(test::bench_of(test::bench_text()));
  return values;
}

TEST(Parameters, HaveNamesUnitsRangesAndSteps)
{
  const std::set<std::string> units{"", "mm", "deg", "px", "ms"};
  std::set<std::string> names;
  for (const Parameter& parameter : parameters()) {
    SCOPED_TRACE(parameter.name);
    EXPECT_TRUE(names.insert(parameter.name).second);
    EXPECT_EQ(units.count(parameter.unit), 1u);
    EXPECT_LT(parameter.least, parameter.most);
    EXPECT_GT(parameter.step, 0.0);
    EXPECT_LT(parameter.step, parameter.most - parameter.least);
    EXPECT_EQ(parameter_named(parameter.name), names.size() - 1);
  }
  // Three of the bench, two common to both eyes, six poses of six numbers, ten of each eye.
  EXPECT_EQ(names.size(), 3u + 2u + 36u + 20u);
  EXPECT_FALSE(parameter_named("no.such").has_value());
}

TEST(Parameters, KeepWhatTheyAreSetToWithinTheirRange)
{
  BenchValues values = nominal_values();
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    const Parameter& parameter = parameters()[k];
    SCOPED_TRACE(parameter.name);
    const double range = parameter.most - parameter.least;
    for (const double wanted : {parameter.least, parameter.least + 0.375 * range, parameter.most}) {
      set_value(values, k, wanted);
      EXPECT_NEAR(value_of(values, k), wanted, rounding);
    }
    set_value(values, k, parameter.most + range);
    EXPECT_NEAR(value_of(values, k), parameter.most, rounding);
    set_value(values, k, parameter.least - range);
    EXPECT_NEAR(value_of(values, k), parameter.least, rounding);
  }
}

TEST(Parameters, ChangeNothingButThemselves)
{
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    SCOPED_TRACE(parameters()[k].name);
    const BenchValues before = nominal_values();
    BenchValues after = before;
    set_value(after, k, value_of(before, k) + parameters()[k].step);
    std::vector<std::string> changed;
    for (std::size_t other = 0; other < parameters().size(); ++other) {
      if (value_of(after, other) != value_of(before, other)) changed.push_back(parameters()[other].name);
    }
    EXPECT_EQ(changed, std::vector<std::string>{parameters()[k].name});
  }
}

TEST(Parameters, KeptOnesSurviveTheFileAndTheOthersAreNotInIt)
{
  const BenchFile bench = test::bench_of(test::bench_text());
  const std::string nominal = calibration_text(nominal_calibration(bench), bench);
  int n_kept = 0;
  for (std::size_t k = 0; k < parameters().size(); ++k) {
    const Parameter& parameter = parameters()[k];
    SCOPED_TRACE(parameter.name);
    BenchValues values = nominal_values();
    set_value(values, k, value_of(values, k) + 2.0 * parameter.step);
    const std::string text = calibration_text(values.calibration, bench);
    BenchValues read;
    read.calibration = parsed_calibration(text, "c.toml", bench);
    EXPECT_EQ(text != nominal, parameter.is_kept);
    // Values that are not in the file would be lost at the next start.
    EXPECT_EQ(read.calibration.eyes.left.distortion.pixel_aspect,
              values.calibration.eyes.left.distortion.pixel_aspect);
    EXPECT_EQ(read.calibration.eyes.right.distortion.pixel_aspect,
              values.calibration.eyes.right.distortion.pixel_aspect);
    for (std::size_t other = 3; other < parameters().size(); ++other)
      EXPECT_NEAR(value_of(read, other), value_of(values, other), rounding) << parameters()[other].name;
    n_kept += parameter.is_kept ? 1 : 0;
  }
  EXPECT_EQ(n_kept, static_cast<int>(parameters().size()) - 3);
}

TEST(Parameters, TheDistanceBetweenTheEyesKeepsTheirMiddle)
{
  BenchValues values = nominal_values();
  values.calibration.eyes.left.position_head_mm.x() = -30.0;
  values.calibration.eyes.right.position_head_mm.x() = 34.0;
  set_value(values, parameter_named("eyes.distance_apart").value(), 60.0);
  EXPECT_EQ(values.calibration.eyes.left.position_head_mm.x(), -28.0);
  EXPECT_EQ(values.calibration.eyes.right.position_head_mm.x(), 32.0);
}

}  // namespace vrda::parameters_test
