#include "analysis/smooth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/smooth_inputs.hpp"
#include "core/text.hpp"
#include "store/motion.hpp"
#include "support/refusal.hpp"

namespace vrda::analysis::smooth_test {

using test::axis;
using test::blank;
using test::input_error;

/// Backward stable least squares: error of a few terms times epsilon times the condition number (below 100
/// for the grids here) times the size of the data (below 100).
constexpr double fit_tolerance = 1e-11;

/// A polynomial of total degree `degree` with every term, in monomials of the scaled axes.
double polynomial(double u, double v, int degree, double shift)
{
  double sum = 0.0, power_u = 1.0;
  for (int i = 0; i <= degree; ++i, power_u *= u) {
    double power_v = 1.0;
    for (int j = 0; i + j <= degree; ++j, power_v *= v)
      sum += (shift + 3.0 * i - 2.0 * j) * power_u * power_v;
  }
  return sum;
}

void fill_with_polynomial(SmoothInput& input, int degree)
{
  const store::AxisRanges ranges = store::axis_ranges(input.flexion_deg, input.varus_deg);
  for (Eigen::Index i = 0; i < input.tx_mm.rows(); ++i) {
    for (Eigen::Index j = 0; j < input.tx_mm.cols(); ++j) {
      const double u = store::unit_coordinate(input.flexion_deg[static_cast<std::size_t>(i)], ranges.flexion);
      const double v = store::unit_coordinate(input.varus_deg[static_cast<std::size_t>(j)], ranges.varus);
      input.tx_mm(i, j) = polynomial(u, v, degree, 1.0);
      input.ty_mm(i, j) = polynomial(u, v, degree, -2.0);
      input.tz_mm(i, j) = polynomial(v, u, degree, 0.5);
      input.theta_deg(i, j) = polynomial(u, -v, degree, 4.0);
    }
  }
}

void fill_with_noise(SmoothInput& input)
{
  test::UniformNumbers numbers(7);
  test::fill(input, [&](double, double) { return numbers.next(); });
}

TEST(Smooth, ReproducesPolynomialsOfItsDegree)
{
  for (const int degree : {0, 1, 2, 3, 6, 8}) {
    SCOPED_TRACE(degree);
    SmoothInput input = blank(axis(31, 0, 3), axis(11, -10, 2));
    fill_with_polynomial(input, degree);
    const store::SmoothedSet set = smooth(input, degree);
    EXPECT_EQ(set.degree, degree);
    EXPECT_EQ(set.exponents.rows(), (degree + 1) * (degree + 2) / 2);
    const store::GridD* grids[] = {&input.tx_mm, &input.ty_mm, &input.tz_mm, &input.theta_deg};
    const char* names[] = {"tx", "ty", "tz", "theta"};
    ASSERT_EQ(set.surfaces.size(), 4u);
    for (std::size_t s = 0; s < 4; ++s) {
      const store::SmoothedSurface& surface = set.surfaces[s];
      EXPECT_EQ(surface.name, names[s]);
      EXPECT_EQ(surface.n_cells, 31 * 11);
      EXPECT_LT((surface.values - *grids[s]).abs().maxCoeff(), fit_tolerance);
      EXPECT_LT(surface.largest_residual, fit_tolerance);
      EXPECT_LE(surface.rms, surface.largest_residual);
      EXPECT_LT(surface.leave_one_out_rms, fit_tolerance);
      EXPECT_GE(surface.condition_number, 1.0);
      EXPECT_LT(surface.condition_number, 100.0);
    }
  }
}

TEST(Smooth, DegreeZeroIsTheMean)
{
  SmoothInput input = blank({0, 1}, {-1, 1});
  input.tx_mm << 1, 2, 3, 6;
  const store::SmoothedSurface surface = smooth(input, 0).surfaces[0];
  EXPECT_NEAR(surface.coefficients.at(0), 3.0, fit_tolerance);
  EXPECT_NEAR(surface.rms, std::sqrt((4.0 + 1.0 + 0.0 + 9.0) / 4.0), fit_tolerance);
  EXPECT_NEAR(surface.largest_residual, 3.0, fit_tolerance);
  // Omitting one of four moves the mean by a third of its residual.
  EXPECT_NEAR(surface.leave_one_out_rms, surface.rms * 4.0 / 3.0, fit_tolerance);
  EXPECT_NEAR(surface.condition_number, 1.0, fit_tolerance);
}

TEST(Smooth, FailedCellsDoNotMatter)
{
  SmoothInput input = blank(axis(19, 0, 5), axis(9, -8, 2));
  fill_with_polynomial(input, 4);
  const store::GridD wanted = input.ty_mm;
  for (Eigen::Index k = 0; k < input.status.size(); k += 7) {
    input.status.data()[k] =
        static_cast<std::int8_t>(k % 2 == 0 ? StepStatus::no_contact : StepStatus::pending);
    input.tx_mm.data()[k] = input.ty_mm.data()[k] = input.tz_mm.data()[k] = input.theta_deg.data()[k] = nan;
  }
  const store::SmoothedSet set = smooth(input, 4);
  EXPECT_EQ(set.surfaces[1].n_cells, (input.status == 0).count());
  EXPECT_LT((set.surfaces[1].values - wanted).abs().maxCoeff(), fit_tolerance);
}

TEST(Smooth, ThetaIsFittedWhereItIsDetermined)
{
  SmoothInput input = blank(axis(10, 0, 10), axis(7, -3, 1));
  fill_with_polynomial(input, 3);
  const store::GridD wanted = input.theta_deg;
  for (Eigen::Index k = 0; k < input.status.size(); k += 5) {
    input.theta_determined.data()[k] = 0;
    input.theta_deg.data()[k] = 1e6;
  }
  const store::SmoothedSet set = smooth(input, 3);
  EXPECT_EQ(set.surfaces[0].n_cells, 70);
  EXPECT_EQ(set.surfaces[3].n_cells, 56);
  EXPECT_LT((set.surfaces[3].values - wanted).abs().maxCoeff(), fit_tolerance);
}

TEST(Smooth, LeaveOneOutIsThatOfRefits)
{
  SmoothInput input = blank(axis(7, 0, 15), axis(5, -2, 1));
  fill_with_noise(input);
  input.status(2, 3) = static_cast<std::int8_t>(StepStatus::iteration_limit);
  const int degree = 3;
  const store::SmoothedSet whole = smooth(input, degree);
  double sum_sq = 0.0;
  int n = 0;
  for (Eigen::Index k = 0; k < input.status.size(); ++k) {
    if (input.status.data()[k] != 0) continue;
    SmoothInput without = input;
    without.status.data()[k] = status_pending;
    const double error = input.tx_mm.data()[k] - smooth(without, degree).surfaces[0].values.data()[k];
    sum_sq += error * error;
    ++n;
  }
  EXPECT_EQ(n, 34);
  EXPECT_NEAR(whole.surfaces[0].leave_one_out_rms, std::sqrt(sum_sq / n), fit_tolerance);
  EXPECT_GT(whole.surfaces[0].leave_one_out_rms, whole.surfaces[0].rms);
}

TEST(Smooth, LeaveOneOutIsUnknownWhereNothingCanBeLeftOut)
{
  SmoothInput input = blank({0, 1}, {-1, 1});
  fill_with_noise(input);
  input.status(1, 1) = static_cast<std::int8_t>(StepStatus::no_clearance);
  const store::SmoothedSurface surface = smooth(input, 1).surfaces[0];
  EXPECT_LT(surface.largest_residual, fit_tolerance);
  EXPECT_TRUE(std::isnan(surface.leave_one_out_rms));
}

TEST(Smooth, ScalingAndShiftingTheAxesChangesNothing)
{
  // Powers of two and whole numbers keep the bits of the unit coordinates, hence of all results.
  SmoothInput input = blank(axis(13, 0, 5), axis(9, -8, 2));
  fill_with_noise(input);
  SmoothInput moved = input;
  for (double& value : moved.flexion_deg) value = 4.0 * value - 30.0;
  for (double& value : moved.varus_deg) value = 0.5 * value + 7.0;
  const store::SmoothedSet a = smooth(input, 5), b = smooth(moved, 5);
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(a.surfaces[s].coefficients, b.surfaces[s].coefficients);
    EXPECT_TRUE((a.surfaces[s].values == b.surfaces[s].values).all());
    EXPECT_EQ(a.surfaces[s].leave_one_out_rms, b.surfaces[s].leave_one_out_rms);
    EXPECT_EQ(a.surfaces[s].condition_number, b.surfaces[s].condition_number);
  }
}

TEST(Smooth, AnAxisWithOneValueCarriesItsConstant)
{
  SmoothInput input = blank(axis(10, 0, 10), {0});
  fill_with_polynomial(input, 4);
  const store::SmoothedSet set = smooth(input, 4);
  EXPECT_EQ(set.exponents.rows(), 5);
  EXPECT_TRUE((set.exponents.col(1) == 0).all());
  EXPECT_LT((set.surfaces[0].values - input.tx_mm).abs().maxCoeff(), fit_tolerance);

  SmoothInput across = blank({30}, axis(6, -5, 2));
  fill_with_polynomial(across, 2);
  EXPECT_EQ(smooth(across, 2).exponents.rows(), 3);
  SmoothInput one = blank({30}, {0});
  EXPECT_EQ(smooth(one, 6).exponents.rows(), 1);
}

TEST(Smooth, FiveColumnsCannotCarryDegreeFive)
{
  SmoothInput input = blank(axis(91, 0, 1), axis(5, -2, 1));
  EXPECT_NO_THROW(smooth(input, 4));
  EXPECT_EQ(largest_degree(input), 4);
  EXPECT_THAT(input_error([&] { smooth(input, 5); }),
              test::refuses({"knee.h5", "smooth.degrees", {"455", "91", "5"}, {"21", "5", "4"}}));
}

TEST(Smooth, TooFewCellsAreCounted)
{
  SmoothInput input = blank(axis(6, 0, 1), axis(6, 0, 1));
  input.status.setConstant(static_cast<std::int8_t>(StepStatus::no_contact));
  EXPECT_EQ(largest_degree(input), -1);
  EXPECT_THAT(input_error([&] { smooth(input, 2); }),
              test::refuses({.field = "smooth.degrees", .wanted = {"6", "2"}}));
  input.status(0, 0) = input.status(0, 5) = input.status(5, 0) = input.status(5, 5) = 0;
  EXPECT_EQ(largest_degree(input), 1);
  EXPECT_THAT(input_error([&] { smooth(input, 2); }),
              test::refuses({.field = "smooth.degrees", .found = {"4", "2"}, .wanted = {"6", "2", "1"}}));
}

TEST(Smooth, ThetaIsFittedToAllCellsWhereTooFewDetermineIt)
{
  // A ball in a socket: theta keeps the value of its seed everywhere.
  SmoothInput input = blank(axis(6, 0, 1), axis(6, 0, 1));
  input.theta_determined.setZero();
  input.theta_determined(2, 2) = 1;
  input.theta_deg.setConstant(7.5);
  EXPECT_EQ(largest_degree(input), 5);
  const store::SmoothedSet set = smooth(input, 3);
  EXPECT_EQ(set.surfaces[3].n_cells, 36);
  // A constant is in the basis: residuals are rounding.
  EXPECT_LT((set.surfaces[3].values - 7.5).abs().maxCoeff(), 1e-12);
  EXPECT_EQ(smooth(input, 0).surfaces[3].n_cells, 1) << "one cell determines a constant";
}

TEST(Smooth, ADegreeOutOfRangeIsRefused)
{
  const SmoothInput input = blank(axis(6, 0, 1), axis(6, 0, 1));
  for (const int degree : {-1, 21}) {
    EXPECT_THAT(
        input_error([&] { smooth(input, degree); }),
        test::refuses({.field = "smooth.degrees", .found = std::to_string(degree), .wanted = {"0", "20"}}));
  }
}

}  // namespace vrda::analysis::smooth_test
