#include "compare/roughness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "smooth/smooth.hpp"

namespace vrda::roughness_test {

/// Sums of some hundred products of numbers near 1.
constexpr double rounding = 1e-11;

struct Fitted {
  SmoothedSet set;
  AxisRanges ranges;
};

/// tx is value(flexion, varus) over 0 to 90 and -10 to 10 degrees, which the degree reproduces.
template <typename Value>
Fitted fitted(int degree, const Value& value)
{
  SmoothInput input;
  for (int i = 0; i <= 30; ++i) input.flexion_deg.push_back(3.0 * i);
  for (int j = 0; j <= 10; ++j) input.varus_deg.push_back(2.0 * j - 10.0);
  input.tx_mm = input.ty_mm = input.tz_mm = input.theta_deg = GridD::Zero(31, 11);
  input.status = GridB::Zero(31, 11);
  input.theta_determined = GridB::Ones(31, 11);
  for (int i = 0; i <= 30; ++i) {
    for (int j = 0; j <= 10; ++j) input.tx_mm(i, j) = value(3.0 * i, 2.0 * j - 10.0);
  }
  return {smooth(input, degree), axis_ranges(input.flexion_deg, input.varus_deg)};
}

double roughness_of(const Fitted& f)
{
  return roughness(f.set, f.set.surfaces[0], f.ranges);
}

TEST(Roughness, OfAPlaneIsNothing)
{
  EXPECT_NEAR(roughness_of(fitted(4, [](double f, double w) { return 3.0 + 0.1 * f - 0.2 * w; })), 0.0,
              rounding);
}

TEST(Roughness, OfQuadraticsIsTheirCurvature)
{
  // s = a f^2 + b f w + c w^2: s_ff = 2a, s_fw = b, s_ww = 2c everywhere.
  struct Row {
    double a, b, c;
  };
  for (const Row row : {Row{0.01, 0, 0}, Row{0, 0.02, 0}, Row{0, 0, -0.05}, Row{0.01, -0.02, 0.03}}) {
    const auto value = [&](double f, double w) { return row.a * f * f + row.b * f * w + row.c * w * w; };
    const double wanted = std::sqrt(4 * row.a * row.a + 2 * row.b * row.b + 4 * row.c * row.c);
    for (const int degree : {2, 5}) EXPECT_NEAR(roughness_of(fitted(degree, value)), wanted, rounding);
  }
}

TEST(Roughness, OfACubicIsTheMeanOverTheRange)
{
  // s = f^3: s_ff = 6 f, whose mean square over 0 to 90 is 36 * 90^2 / 3. The values reach 7e5.
  EXPECT_NEAR(roughness_of(fitted(3, [](double f, double) { return f * f * f; })),
              6.0 * 90.0 / std::sqrt(3.0), 1e6 * rounding);
}

TEST(Roughness, AgreesWithDifferencesOfTheSurface)
{
  std::mt19937_64 generator(5);
  const Fitted f = fitted(6, [&](double, double) { return static_cast<double>(generator() % 1000) / 500.0; });
  const auto value = [&](double flexion, double varus) {
    return evaluate(f.set, f.set.surfaces[0], f.ranges, flexion, varus).value;
  };
  // Midpoints of a fine grid; second differences with a step of 0.05 degrees.
  constexpr double h = 0.05;
  constexpr int n = 200;
  double sum = 0.0;
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      const double x = 90.0 * (a + 0.5) / n, y = 20.0 * (b + 0.5) / n - 10.0, s = value(x, y);
      const double ff = (value(x + h, y) - 2 * s + value(x - h, y)) / (h * h);
      const double ww = (value(x, y + h) - 2 * s + value(x, y - h)) / (h * h);
      const double fw =
          (value(x + h, y + h) - value(x + h, y - h) - value(x - h, y + h) + value(x - h, y - h)) /
          (4 * h * h);
      sum += ff * ff + 2 * fw * fw + ww * ww;
    }
  }
  const double wanted = std::sqrt(sum / (n * n));
  EXPECT_GT(wanted, 1e-3);
  // Midpoint rule on 200 cells of a polynomial of degree 8: under a thousandth; differences less.
  EXPECT_NEAR(roughness_of(f), wanted, 1e-3 * wanted);
}

TEST(Roughness, AnAxisWithOneValueAddsNothing)
{
  SmoothInput input;
  for (int i = 0; i <= 10; ++i) input.flexion_deg.push_back(9.0 * i);
  input.varus_deg = {0.0};
  input.tx_mm = GridD::Zero(11, 1);
  for (int i = 0; i <= 10; ++i) input.tx_mm(i, 0) = 0.01 * 81.0 * i * i;
  input.ty_mm = input.tz_mm = input.theta_deg = input.tx_mm;
  input.status = GridB::Zero(11, 1);
  input.theta_determined = GridB::Ones(11, 1);
  const SmoothedSet set = smooth(input, 3);
  EXPECT_NEAR(roughness(set, set.surfaces[0], axis_ranges(input.flexion_deg, input.varus_deg)), 0.02,
              rounding);
}

}  // namespace vrda::roughness_test
