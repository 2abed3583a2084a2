#include "bench/calibration_file.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "player/bench/bench_texts.hpp"

namespace vrda::parameters_test {

/// Of an angle converted to degrees and back.
constexpr double rounding = 1e-10;

bench::BenchValues nominal_values()
{
  bench::BenchValues values;
  values.calibration = bench::nominal_calibration(test::bench_of(test::bench_text()));
  return values;
}

TEST(Parameters, HaveNamesUnitsRangesAndSteps)
{
  const std::set<std::string> units{"", "mm", "deg", "px", "ms"};
  std::set<std::string> names;
  for (const bench::Parameter& parameter : bench::parameters()) {
    SCOPED_TRACE(parameter.name);
    EXPECT_TRUE(names.insert(parameter.name).second);
    EXPECT_EQ(units.count(parameter.unit), 1u);
    EXPECT_LT(parameter.minimum, parameter.maximum);
    EXPECT_GT(parameter.step, 0.0);
    EXPECT_LT(parameter.step, parameter.maximum - parameter.minimum);
    EXPECT_EQ(bench::find_parameter(parameter.name), names.size() - 1);
  }
  // Three of the bench, two common to both eyes, six poses of six numbers, ten of each eye.
  EXPECT_EQ(names.size(), 3u + 2u + 36u + 20u);
  EXPECT_FALSE(bench::find_parameter("no.such").has_value());
}

TEST(Parameters, KeepWhatTheyAreSetToWithinTheirRange)
{
  bench::BenchValues values = nominal_values();
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    const bench::Parameter& parameter = bench::parameters()[k];
    SCOPED_TRACE(parameter.name);
    const double range = parameter.maximum - parameter.minimum;
    for (const double wanted : {parameter.minimum, parameter.minimum + 0.375 * range, parameter.maximum}) {
      bench::set_value(values, k, wanted);
      EXPECT_NEAR(bench::value_of(values, k), wanted, rounding);
    }
    bench::set_value(values, k, parameter.maximum + range);
    EXPECT_NEAR(bench::value_of(values, k), parameter.maximum, rounding);
    bench::set_value(values, k, parameter.minimum - range);
    EXPECT_NEAR(bench::value_of(values, k), parameter.minimum, rounding);
  }
}

TEST(Parameters, ChangeNothingButThemselves)
{
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    SCOPED_TRACE(bench::parameters()[k].name);
    const bench::BenchValues before = nominal_values();
    bench::BenchValues after = before;
    bench::set_value(after, k, bench::value_of(before, k) + bench::parameters()[k].step);
    std::vector<std::string> changed;
    for (std::size_t other = 0; other < bench::parameters().size(); ++other) {
      if (bench::value_of(after, other) != bench::value_of(before, other))
        changed.push_back(bench::parameters()[other].name);
    }
    EXPECT_EQ(changed, std::vector<std::string>{bench::parameters()[k].name});
  }
}

TEST(Parameters, KeptOnesSurviveTheFileAndTheOthersAreNotInIt)
{
  const bench::BenchFile bench = test::bench_of(test::bench_text());
  const std::string nominal = bench::calibration_text(bench::nominal_calibration(bench), bench);
  int n_kept = 0;
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    const bench::Parameter& parameter = bench::parameters()[k];
    SCOPED_TRACE(parameter.name);
    bench::BenchValues values = nominal_values();
    bench::set_value(values, k, bench::value_of(values, k) + 2.0 * parameter.step);
    const std::string text = bench::calibration_text(values.calibration, bench);
    bench::BenchValues read;
    read.calibration = bench::parse_calibration(text, "c.toml", bench);
    EXPECT_EQ(text != nominal, parameter.is_saved);
    // Values that are not in the file would be lost at the next start.
    EXPECT_EQ(read.calibration.eyes.left.distortion.pixel_aspect,
              values.calibration.eyes.left.distortion.pixel_aspect);
    EXPECT_EQ(read.calibration.eyes.right.distortion.pixel_aspect,
              values.calibration.eyes.right.distortion.pixel_aspect);
    for (std::size_t other = 3; other < bench::parameters().size(); ++other)
      EXPECT_NEAR(bench::value_of(read, other), bench::value_of(values, other), rounding)
          << bench::parameters()[other].name;
    n_kept += parameter.is_saved ? 1 : 0;
  }
  EXPECT_EQ(n_kept, static_cast<int>(bench::parameters().size()) - 3);
}

TEST(Parameters, TheDistanceBetweenTheEyesKeepsTheirMiddle)
{
  bench::BenchValues values = nominal_values();
  values.calibration.eyes.left.position_head_mm.x() = -30.0;
  values.calibration.eyes.right.position_head_mm.x() = 34.0;
  bench::set_value(values, bench::find_parameter("eyes.distance_apart").value(), 60.0);
  EXPECT_EQ(values.calibration.eyes.left.position_head_mm.x(), -28.0);
  EXPECT_EQ(values.calibration.eyes.right.position_head_mm.x(), 32.0);
}

}  // namespace vrda::parameters_test
