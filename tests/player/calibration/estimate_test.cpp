#include "bench/calibration_file.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"

namespace vrda::calibration::estimate_test {

TEST(StudentsT, IsThatOfTheTables)
{
  constexpr double last_digit = 5e-4;
  EXPECT_NEAR(bench::t_95(1.0), 12.706, last_digit);
  EXPECT_NEAR(bench::t_95(10.0), 2.228, last_digit);
  EXPECT_NEAR(bench::t_95(60.0), 2.000, last_digit);
  EXPECT_NEAR(bench::t_95(std::numeric_limits<double>::infinity()), 1.960, last_digit);
  EXPECT_NEAR(bench::t_95(1e9), 1.960, last_digit);
}

bench::Estimate one(const std::string& name, double value, double variance, double dof)
{
  bench::Estimate estimate;
  estimate.names = {name};
  estimate.units = {"px"};
  estimate.values = Eigen::VectorXd::Constant(1, value);
  estimate.covariance = Eigen::MatrixXd::Constant(1, 1, variance);
  estimate.dof = dof;
  bench::set_residuals(estimate, {value, -value}, "px");
  estimate.remarks = {"about " + name};
  return estimate;
}

TEST(Estimate, AppendingKeepsBothAndTheFewerDegreesOfFreedom)
{
  bench::Estimate whole;
  bench::append(whole, one("a", 3.0, 4.0, 10.0));
  EXPECT_EQ(whole.dof, 10.0);
  bench::append(whole, one("b", 4.0, 9.0, 5.0));
  bench::append(whole, one("c", 5.0, 16.0, 7.0));
  EXPECT_EQ(whole.names, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(whole.units.size(), 3U);
  EXPECT_EQ(whole.dof, 5.0);
  EXPECT_EQ(whole.values, Eigen::Vector3d(3.0, 4.0, 5.0));
  EXPECT_EQ(whole.covariance, Eigen::MatrixXd(Eigen::Vector3d(4.0, 9.0, 16.0).asDiagonal()));
  EXPECT_EQ(whole.residuals, (std::vector<double>{3.0, -3.0, 4.0, -4.0, 5.0, -5.0}));
  EXPECT_DOUBLE_EQ(whole.residual_rms, std::sqrt(50.0 / 3.0));
  EXPECT_EQ(whole.remarks.size(), 3U);
  EXPECT_EQ(bench::index_of(whole, "b"), 1);
  EXPECT_EQ(bench::index_of(whole, "d"), -1);
}

TEST(IntervalText, LeavesTwoDigitsOfTheInterval)
{
  const auto text = [](double value, double half_width, const std::string& unit) {
    const double sd = half_width / bench::t_95(std::numeric_limits<double>::infinity());
    bench::Estimate estimate = one("x", value, sd * sd, std::numeric_limits<double>::infinity());
    estimate.units = {unit};
    return bench::interval_text(estimate, 0);
  };
  EXPECT_EQ(text(879.9163, 1.4142, "px"), "879.9 +- 1.4 px");
  EXPECT_EQ(text(0.0214567, 0.000345, ""), "0.02146 +- 0.00035");
  EXPECT_EQ(text(-12.0, 35.0, "mm"), "-12 +- 35 mm");
}

}  // namespace vrda::calibration::estimate_test
