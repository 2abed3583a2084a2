#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "bench/calibration_file.hpp"
#include "calibration/least_squares.hpp"
#include "core/units.hpp"

namespace vrda::calibration::least_squares_test {

using Eigen::VectorXd;

/// Rounding error with difference steps of 1e-6 of a scale of 1 and final Gauss-Newton steps.
constexpr double solver_tolerance = 1e-9;

FitProblem problem_of(std::function<VectorXd(const VectorXd&)> residuals, const VectorXd& start)
{
  FitProblem problem;
  problem.residuals = std::move(residuals);
  problem.start = start;
  problem.scale = VectorXd::Ones(start.size());
  return problem;
}

/// y = a + b x through (0, 1), (1, 3), (2, 4), (3, 4), noise of 0.5: sums 4, 6, 14, 12, 23.
FitProblem line()
{
  return problem_of(
      [](const VectorXd& p) {
        const Eigen::Array4d x(0, 1, 2, 3), y(1, 3, 4, 4);
        return VectorXd((p[0] + p[1] * x - y) / 0.5);
      },
      VectorXd::Constant(2, 10.0));
}

TEST(LeastSquares, ALineMatchesTheClosedForm)
{
  const LeastSquares fit = calibration::fit_least_squares(line());
  // 4 a + 6 b = 12, 6 a + 14 b = 23; covariance 0.25 (X^T X)^-1 with determinant 20.
  EXPECT_EQ(fit.status, LeastSquaresStatus::converged);
  EXPECT_NEAR(fit.x[0], 1.5, solver_tolerance);
  EXPECT_NEAR(fit.x[1], 1.0, solver_tolerance);
  Eigen::Matrix2d expected;
  expected << 14, -6, -6, 4;
  expected *= 0.25 / 20.0;
  EXPECT_LT((fit.covariance - expected).cwiseAbs().maxCoeff(), solver_tolerance);
  EXPECT_EQ(fit.residuals.size(), 4);
  EXPECT_NEAR(fit.J(3, 1), 6.0, solver_tolerance);
}

/// NIST StRD, Misra1a: y = b1 (1 - exp(-b2 x)), from its far and near start.
TEST(LeastSquares, TheCertifiedValuesOfMisra1aAreFound)
{
  const Eigen::ArrayXd x{
      {77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0}};
  const Eigen::ArrayXd y{
      {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78}};
  for (const Eigen::Vector2d& start : {Eigen::Vector2d(500, 1e-4), Eigen::Vector2d(250, 5e-4)}) {
    FitProblem problem =
        problem_of([&](const VectorXd& b) { return VectorXd(b[0] * (1.0 - (-b[1] * x).exp()) - y); }, start);
    problem.scale = Eigen::Vector2d(100, 1e-4);
    const LeastSquares fit = calibration::fit_least_squares(problem);
    EXPECT_EQ(fit.status, LeastSquaresStatus::converged);
    EXPECT_NEAR(fit.x[0] / 2.3894212918E+02, 1.0, solver_tolerance);
    EXPECT_NEAR(fit.x[1] / 5.5015643181E-04, 1.0, solver_tolerance);
    const double square_sum = fit.residuals.squaredNorm();
    EXPECT_NEAR(square_sum / 1.2455138894E-01, 1.0, solver_tolerance);
    const double variance = square_sum / 12.0;
    // The standard deviations have the precision of the differences in J.
    constexpr double difference_tolerance = 1e-7;
    EXPECT_NEAR(std::sqrt(variance * fit.covariance(0, 0)) / 2.7070075241E+00, 1.0, difference_tolerance);
    EXPECT_NEAR(std::sqrt(variance * fit.covariance(1, 1)) / 7.2668688436E-06, 1.0, difference_tolerance);
  }
}

TEST(LeastSquares, WhatTheResidualsThrowComesOut)
{
  int n_calls = 0;
  FitProblem problem = line();
  const auto residuals = problem.residuals;
  problem.residuals = [&](const VectorXd& x) {
    // Thrown at the start, or within NLopt.
    if (++n_calls > 8) throw std::domain_error("no such place");
    return residuals(x);
  };
  EXPECT_THROW(calibration::fit_least_squares(problem), std::domain_error);
  EXPECT_EQ(n_calls, 9);
}

TEST(LeastSquares, ParametersWithoutUniqueSolutionAreUndetermined)
{
  const LeastSquares fit = calibration::fit_least_squares(problem_of(
      [](const VectorXd& x) {
        const double sum = x[0] + x[1];
        return VectorXd(Eigen::Vector3d(sum - 1.0, 2.0 * sum - 2.5, x[2] * x[2] - 4.0));
      },
      Eigen::Vector3d(0.0, 0.0, 1.0)));
  EXPECT_EQ(fit.status, LeastSquaresStatus::undetermined);
  EXPECT_EQ(fit.covariance, Eigen::MatrixXd::Zero(3, 3));
  EXPECT_NEAR(fit.x[0] + fit.x[1], 1.2, solver_tolerance);
  EXPECT_NEAR(fit.x[2], 2.0, solver_tolerance);
  const LeastSquares few = calibration::fit_least_squares(
      problem_of([](const VectorXd& x) { return VectorXd(x.head(1) + x.tail(1)); }, VectorXd::Ones(2)));
  EXPECT_EQ(few.status, LeastSquaresStatus::undetermined);
}

TEST(LeastSquares, AFitThatNeverEndsSaysSo)
{
  // The minimum is a kink without zero gradient.
  const LeastSquares endless = calibration::fit_least_squares(
      problem_of([](const VectorXd& x) { return VectorXd(1.0 + x.array().max(-2.0 * x.array())); },
                 VectorXd::Constant(1, 3.0)));
  EXPECT_EQ(endless.status, LeastSquaresStatus::iteration_limit);
  const LeastSquares nowhere = calibration::fit_least_squares(
      problem_of([](const VectorXd& x) { return VectorXd((x.array() - 1e9).sqrt()); }, VectorXd::Zero(1)));
  EXPECT_EQ(nowhere.status, LeastSquaresStatus::iteration_limit);
  EXPECT_EQ(nowhere.x, VectorXd::Zero(1));
  EXPECT_EQ(nowhere.covariance, Eigen::MatrixXd::Zero(1, 1));
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

TEST(T95, AgreesWithTables)
{
  // Fisher and Yates, six digits; 1,000 is where the series begins
  const double infinite = std::numeric_limits<double>::infinity();
  for (const auto& [dof, t] : {std::pair{1.0, 12.7062},
                               {2.0, 4.30265},
                               {10.0, 2.22814},
                               {100.0, 1.98397},
                               {999.999, 1.96234},
                               {1000.0, 1.96234},
                               {infinite, 1.95996}})
    EXPECT_NEAR(bench::t_95(dof), t, 5e-6 * t) << dof;
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

}  // namespace vrda::calibration::least_squares_test
