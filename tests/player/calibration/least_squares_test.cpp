#include "calibration/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace vrda::least_squares_test {

using Eigen::VectorXd;

/// Where differences of 1e-6 of a scale of 1 and polishing leave nothing but rounding.
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
  const LeastSquares fit = fit_least_squares(line());
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

TEST(LeastSquares, RosenbrocksValleyIsFollowedToItsEnd)
{
  const LeastSquares fit = fit_least_squares(problem_of(
      [](const VectorXd& x) { return VectorXd(Eigen::Vector2d(10 * (x[1] - x[0] * x[0]), 1 - x[0])); },
      Eigen::Vector2d(-1.2, 1.0)));
  EXPECT_EQ(fit.status, LeastSquaresStatus::converged);
  EXPECT_NEAR(fit.x[0], 1.0, solver_tolerance);
  EXPECT_NEAR(fit.x[1], 1.0, solver_tolerance);
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
    const LeastSquares fit = fit_least_squares(problem);
    EXPECT_EQ(fit.status, LeastSquaresStatus::converged);
    EXPECT_NEAR(fit.x[0] / 2.3894212918E+02, 1.0, solver_tolerance);
    EXPECT_NEAR(fit.x[1] / 5.5015643181E-04, 1.0, solver_tolerance);
    const double square_sum = fit.residuals.squaredNorm();
    EXPECT_NEAR(square_sum / 1.2455138894E-01, 1.0, solver_tolerance);
    const double variance = square_sum / 12.0;
    // The certificate's standard deviations have the differences' precision in J here.
    constexpr double difference_tolerance = 1e-7;
    EXPECT_NEAR(std::sqrt(variance * fit.covariance(0, 0)) / 2.7070075241E+00, 1.0, difference_tolerance);
    EXPECT_NEAR(std::sqrt(variance * fit.covariance(1, 1)) / 7.2668688436E-06, 1.0, difference_tolerance);
  }
}

TEST(LeastSquares, ANumberStopsAtItsBoundAndTheOthersMakeTheBestOfIt)
{
  FitProblem problem = line();
  problem.start = Eigen::Vector2d(0.0, 0.0);
  problem.least = Eigen::Vector2d(-5.0, -5.0);
  problem.most = Eigen::Vector2d(5.0, 0.5);
  const LeastSquares fit = fit_least_squares(problem);
  EXPECT_EQ(fit.status, LeastSquaresStatus::at_a_bound);
  EXPECT_NEAR(fit.x[1], 0.5, solver_tolerance);
  EXPECT_NEAR(fit.x[0], (12.0 - 6.0 * 0.5) / 4.0, solver_tolerance);
  problem.most[1] = 5.0;
  const LeastSquares inside = fit_least_squares(problem);
  EXPECT_EQ(inside.status, LeastSquaresStatus::converged);
  EXPECT_NEAR(inside.x[1], 1.0, solver_tolerance);
}

TEST(LeastSquares, WhatTheResidualsThrowComesOut)
{
  int n_calls = 0;
  FitProblem problem = line();
  const auto residuals = problem.residuals;
  problem.residuals = [&](const VectorXd& x) {
    // Once around the start, then within NLopt.
    if (++n_calls > 8) throw std::domain_error("no such place");
    return residuals(x);
  };
  EXPECT_THROW(fit_least_squares(problem), std::domain_error);
  EXPECT_EQ(n_calls, 9);
}

TEST(LeastSquares, WhatTheResidualsDoNotTellIsUndetermined)
{
  const LeastSquares fit = fit_least_squares(problem_of(
      [](const VectorXd& x) {
        const double sum = x[0] + x[1];
        return VectorXd(Eigen::Vector3d(sum - 1.0, 2.0 * sum - 2.5, x[2] * x[2] - 4.0));
      },
      Eigen::Vector3d(0.0, 0.0, 1.0)));
  EXPECT_EQ(fit.status, LeastSquaresStatus::undetermined);
  EXPECT_EQ(fit.covariance, Eigen::MatrixXd::Zero(3, 3));
  EXPECT_NEAR(fit.x[0] + fit.x[1], 1.2, solver_tolerance);
  EXPECT_NEAR(fit.x[2], 2.0, solver_tolerance);
  const LeastSquares few = fit_least_squares(
      problem_of([](const VectorXd& x) { return VectorXd(x.head(1) + x.tail(1)); }, VectorXd::Ones(2)));
  EXPECT_EQ(few.status, LeastSquaresStatus::undetermined);
}

TEST(LeastSquares, AFitThatNeverEndsSaysSo)
{
  // Its least is a kink, where no slope vanishes.
  const LeastSquares endless = fit_least_squares(
      problem_of([](const VectorXd& x) { return VectorXd(1.0 + x.array().max(-2.0 * x.array())); },
                 VectorXd::Constant(1, 3.0)));
  EXPECT_EQ(endless.status, LeastSquaresStatus::iteration_limit);
  const LeastSquares nowhere = fit_least_squares(
      problem_of([](const VectorXd& x) { return VectorXd((x.array() - 1e9).sqrt()); }, VectorXd::Zero(1)));
  EXPECT_EQ(nowhere.status, LeastSquaresStatus::iteration_limit);
  EXPECT_EQ(nowhere.x, VectorXd::Zero(1));
  EXPECT_EQ(nowhere.covariance, Eigen::MatrixXd::Zero(1, 1));
}

TEST(LeastSquares, EveryStatusHasAName)
{
  EXPECT_STREQ(name_of(LeastSquaresStatus::converged), "converged");
  EXPECT_STREQ(name_of(LeastSquaresStatus::at_a_bound), "at a bound");
  EXPECT_STREQ(name_of(LeastSquaresStatus::iteration_limit), "iteration limit");
  EXPECT_STREQ(name_of(LeastSquaresStatus::undetermined), "undetermined");
}

}  // namespace vrda::least_squares_test
