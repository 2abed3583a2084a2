#include "analysis/smooth.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <random>

namespace vrda::analysis::huber_test {

/// A few dozen operations on numbers near 1, weighted by numbers down to a hundredth.
constexpr double rounding = 1e-11;

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed)
{
  std::mt19937_64 generator(seed);
  Eigen::MatrixXd A(rows, columns);
  for (Eigen::Index k = 0; k < A.size(); ++k)
    A.data()[k] = static_cast<double>(generator() % 2001) / 1000.0 - 1.0;
  return A;
}

/// Noise within [-1, 1]; every tenth datum is an outlier on one side.
Eigen::VectorXd noisy_data(const Eigen::MatrixXd& A)
{
  Eigen::VectorXd data = 3.0 * A.rowwise().sum() + random_matrix(A.rows(), 1, 5);
  for (Eigen::Index i = 0; i < data.size(); i += 10) data(i) += 20.0 + static_cast<double>(i);
  return data;
}

Eigen::VectorXd weighted_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& weights,
                                       const Eigen::VectorXd& data)
{
  const Eigen::MatrixXd normal = A.transpose() * weights.asDiagonal() * A;
  return normal.fullPivLu().solve(A.transpose() * weights.asDiagonal() * data);
}

TEST(PivotedQr, ConditionNumberIsThatOfTheSingularValues)
{
  Eigen::MatrixXd A = random_matrix(60, 15, 3);
  A.col(3) *= 1e4;
  A.col(9) = A.col(8) + 1e-3 * A.col(9);
  const Eigen::VectorXd singular_values = Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues();
  const double wanted = singular_values(0) / singular_values(14);
  EXPECT_GT(wanted, 1e5);
  EXPECT_NEAR(condition_number(pivoted_qr(A)) / wanted, 1.0, 1e-9);
}

TEST(RobustScale, IsTheMedianScaledForNormalNoise)
{
  EXPECT_EQ(robust_scale(Eigen::VectorXd()), 0.0);
  EXPECT_EQ(robust_scale(Eigen::VectorXd{{-2.0}}), 2.0 * normal_scale);
  EXPECT_EQ(robust_scale(Eigen::VectorXd{{5.0, -1.0, 100.0}}), 5.0 * normal_scale);
  EXPECT_EQ(robust_scale(Eigen::VectorXd{{1.0, -4.0, 2.0, -100.0}}), 3.0 * normal_scale);
  // P(|x| < 1 / normal_scale) = 1/2 of a standard normal number.
  EXPECT_NEAR(std::erf(1.0 / normal_scale / std::sqrt(2.0)), 0.5, 1e-12);
}

TEST(HuberFit, SolvesItsEquation)
{
  const Eigen::MatrixXd A = random_matrix(80, 5, 3);
  const Eigen::VectorXd data = noisy_data(A);
  const HuberFit fit = huber_fit(pivoted_qr(A), data);
  ASSERT_TRUE(fit.is_converged);
  const Eigen::VectorXd residual = data - A * fit.coefficients;
  const double scale = robust_scale(residual);
  // The iteration ended at changes of 1e-6 of the scale, which at least halve per step.
  EXPECT_NEAR(fit.scale, scale, 1e-5 * scale);
  Eigen::VectorXd pull = residual;
  int n_limited = 0;
  for (Eigen::Index i = 0; i < 80; ++i) {
    const double limit = huber_constant * scale;
    n_limited += std::abs(residual(i)) > limit ? 1 : 0;
    pull(i) = std::clamp(residual(i), -limit, limit);
  }
  EXPECT_GE(n_limited, 8);
  EXPECT_LT((A.transpose() * pull).cwiseAbs().maxCoeff(), 80 * 1e-5 * scale);
  const Eigen::VectorXd wanted = weighted_least_squares(A, fit.weights, data);
  EXPECT_LT((fit.coefficients - wanted).cwiseAbs().maxCoeff(), rounding);
}

TEST(HuberFit, LeverageIsThatOfRefitsWithTheSameWeights)
{
  const Eigen::MatrixXd A = random_matrix(40, 4, 3);
  const Eigen::VectorXd data = noisy_data(A);
  const HuberFit fit = huber_fit(pivoted_qr(A), data);
  const Eigen::VectorXd residual = data - A * fit.coefficients;
  for (Eigen::Index i = 0; i < 40; ++i) {
    Eigen::VectorXd weights = fit.weights;
    weights(i) = 0.0;
    const double refit = data(i) - A.row(i).dot(weighted_least_squares(A, weights, data));
    EXPECT_NEAR(residual(i) / (1.0 - fit.leverage(i)), refit, 100 * rounding);
  }
}

TEST(HuberFit, AColumnThatOnlyRowsFarOffDetermineTakesWeightedSteps)
{
  // The last column is nonzero where the data are 3000, -1000 and -1500: unweighted steps would converge
  // slowly.
  Eigen::MatrixXd A = random_matrix(60, 3, 4);
  A.col(2).setZero();
  Eigen::VectorXd data = random_matrix(60, 1, 6);
  A(0, 2) = A(1, 2) = A(2, 2) = 1.0;
  data.head(3) << 3000.0, -1000.0, -1500.0;
  const HuberFit fit = huber_fit(pivoted_qr(A), data);
  EXPECT_TRUE(fit.is_converged);
  EXPECT_GT(fit.n_iterations, 30);
  // The median of three, as the other two cancel.
  EXPECT_NEAR(fit.coefficients(2), -1000.0, 3.0);
}

TEST(HuberFit, SaysWhenTheStepsRanOut)
{
  const Eigen::MatrixXd A = random_matrix(80, 5, 3);
  const HuberFit fit = huber_fit(pivoted_qr(A), noisy_data(A), {.max_iterations = 2});
  EXPECT_FALSE(fit.is_converged);
  EXPECT_EQ(fit.n_iterations, 2);
  EXPECT_EQ(fit.coefficients.size(), 5);
}

}  // namespace vrda::analysis::huber_test
