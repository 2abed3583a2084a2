#include "analysis/score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"

namespace vrda::analysis::statistics_test {

// Rounding of sums of some 400 numbers near 1.
constexpr double rounding = 1e-13;

/// A sine over whole periods, `n` samples.
std::vector<double> sine_of(double phase_rad, double amplitude = 1.0, int n = 360)
{
  std::vector<double> values;
  for (int k = 0; k < n; ++k) values.push_back(amplitude * sine(2.0 * pi * k / n + phase_rad));
  return values;
}

TEST(ScoreStatistics, RmsSplitsIntoBiasAndShape)
{
  // differences 4 and 0: RMS sqrt(8), bias 2, shape 2
  const Statistics s = statistics({5, 3}, {1, 3});
  EXPECT_NEAR(s.rms, std::sqrt(8.0), rounding);
  EXPECT_NEAR(s.bias, 2.0, rounding);
  EXPECT_NEAR(s.shape, 2.0, rounding);
  EXPECT_EQ(s.largest, 4.0);
  EXPECT_EQ(s.largest_at, 0u);
}

TEST(ScoreStatistics, AShiftedSineHasTheCosineOfItsShift)
{
  // over whole periods: correlation cos(p), RMS of the difference 2 sin(p / 2) / sqrt(2); amplitude does not
  // change the correlation, a sign does
  for (const double shift_rad : {0.0, 0.4, pi / 2, 2.0, pi}) {
    SCOPED_TRACE(shift_rad);
    const Statistics s = statistics(sine_of(shift_rad), sine_of(0.0));
    EXPECT_NEAR(s.correlation, cosine(shift_rad), rounding);
    EXPECT_NEAR(s.rms, std::sqrt(2.0) * sine(shift_rad / 2), rounding);
    EXPECT_NEAR(s.bias, 0.0, rounding);
    EXPECT_NEAR(statistics(sine_of(shift_rad, 3.0), sine_of(0.0)).correlation, cosine(shift_rad), rounding);
    EXPECT_NEAR(statistics(sine_of(shift_rad, -1.0), sine_of(0.0)).correlation, -cosine(shift_rad), rounding);
  }
}

TEST(ScoreStatistics, AConstantHasNoCorrelation)
{
  // 0.1 added ten times has a mean that is not 0.1: rounding is no variation
  const std::vector<double> constant(10, 0.1), varying{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_TRUE(std::isnan(statistics(constant, varying).correlation));
  EXPECT_TRUE(std::isnan(statistics(varying, constant).correlation));
  EXPECT_NEAR(statistics(varying, varying).correlation, 1.0, rounding);
}

TEST(ScoreStatistics, WithoutFramesNothingIsKnown)
{
  const Statistics s = statistics({}, {});
  EXPECT_EQ(s.n, 0u);
  for (const double value : {s.rms, s.bias, s.shape, s.correlation, s.largest})
    EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(std::isnan(rms_of({}, {}, {})));
}

TEST(Baseline, OfAStraightLineIsZero)
{
  const std::vector<double> x{3, -1, 4, 10};
  std::vector<double> values;
  for (const double value : x) values.push_back(2.0 - 0.5 * value);
  EXPECT_NEAR(rms_of(straight_line(x, values), x, values), 0.0, rounding);
  EXPECT_NEAR(straight_line(x, values).slope, -0.5, rounding);
  const std::vector<double> same(3, 0.1);  // over a constant the line is the constant
  EXPECT_NEAR(straight_line(same, {1, 2, 6}).at(17.0), 3.0, rounding);
  // the constant leaves the standard deviation: x has mean 4, squares of the deviations 1, 25, 0, 36
  EXPECT_NEAR(rms_of(constant(values), x, values), 0.5 * std::sqrt(62.0 / 4.0), rounding);
}

TEST(Baseline, TheLineIsNeverWorseThanTheConstantWhereItIsFitted)
{
  const std::vector<double> x = sine_of(0.0), values = sine_of(1.1);
  // the line explains the square of the correlation: what is left is sin(1.1) / sqrt(2)
  EXPECT_NEAR(rms_of(straight_line(x, values), x, values), sine(1.1) / std::sqrt(2.0), rounding);
  EXPECT_NEAR(rms_of(constant(values), x, values), 1.0 / std::sqrt(2.0), rounding);
}

}  // namespace vrda::analysis::statistics_test
