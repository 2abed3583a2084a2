#include "analysis/smooth.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <random>

#include "core/text.hpp"

namespace vrda::least_squares_test {

/// A few dozen operations on numbers near 1.
constexpr double rounding = 1e-12;

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns)
{
  std::mt19937_64 generator(3);
  Eigen::MatrixXd A(rows, columns);
  for (Eigen::Index k = 0; k < A.size(); ++k)
    A.data()[k] = static_cast<double>(generator() % 2001) / 1000.0 - 1.0;
  return A;
}

TEST(PivotedQr, IsADecomposition)
{
  const Eigen::MatrixXd A = random_matrix(40, 9);
  const analysis::PivotedQr qr = analysis::pivoted_qr(A);
  EXPECT_EQ(qr.rank, 9);
  EXPECT_LT((qr.Q.transpose() * qr.Q - Eigen::MatrixXd::Identity(9, 9)).cwiseAbs().maxCoeff(), rounding);
  const Eigen::MatrixXd product = qr.Q * qr.R;
  for (Eigen::Index k = 0; k < 9; ++k) {
    EXPECT_LT((product.col(k) - A.col(qr.order(k))).cwiseAbs().maxCoeff(), rounding);
  }
}

TEST(PivotedQr, CountsIndependentColumns)
{
  Eigen::MatrixXd A = random_matrix(30, 6);
  A.col(2) = A.col(0) + 2.0 * A.col(4);
  EXPECT_EQ(analysis::pivoted_qr(A).rank, 5);
  A.col(1) = -A.col(5);
  EXPECT_EQ(analysis::pivoted_qr(A).rank, 4);
  A.col(3).setZero();
  EXPECT_EQ(analysis::pivoted_qr(A).rank, 3);
  EXPECT_EQ(analysis::pivoted_qr(Eigen::MatrixXd::Zero(4, 2)).rank, 0);
}

TEST(PivotedQr, SolvesLikeTheNormalEquations)
{
  const Eigen::MatrixXd A = random_matrix(50, 7);
  const Eigen::VectorXd b = random_matrix(50, 1);
  const Eigen::VectorXd residual = b - A * analysis::solve(analysis::pivoted_qr(A), b);
  EXPECT_LT((A.transpose() * residual).cwiseAbs().maxCoeff(), rounding);
}

TEST(PivotedQr, LeveragesAreTheHatMatrix)
{
  const Eigen::MatrixXd A = random_matrix(20, 4);
  const Eigen::MatrixXd hat = A * (A.transpose() * A).inverse() * A.transpose();
  const Eigen::VectorXd leverage = analysis::leverages(analysis::pivoted_qr(A));
  for (Eigen::Index i = 0; i < 20; ++i) EXPECT_NEAR(leverage(i), hat(i, i), rounding);
}

TEST(PivotedQr, ConditionNumberIsThatOfTheSingularValues)
{
  Eigen::MatrixXd A = random_matrix(60, 15);
  A.col(3) *= 1e4;
  A.col(9) = A.col(8) + 1e-3 * A.col(9);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A);
  const double wanted = svd.singularValues()(0) / svd.singularValues()(14);
  EXPECT_GT(wanted, 1e5);
  EXPECT_NEAR(analysis::condition_number(analysis::pivoted_qr(A)) / wanted, 1.0, 1e-9);
  EXPECT_NEAR(analysis::condition_number(analysis::pivoted_qr(Eigen::MatrixXd::Identity(5, 3))), 1.0,
              rounding);
}

TEST(PivotedQr, KeepsItsPromises)
{
  EXPECT_THROW(analysis::pivoted_qr(Eigen::MatrixXd::Zero(2, 3)), InternalError);
  const analysis::PivotedQr deficient = analysis::pivoted_qr(Eigen::MatrixXd::Ones(4, 2));
  EXPECT_THROW(analysis::solve(deficient, Eigen::VectorXd::Ones(4)), InternalError);
  EXPECT_THROW(analysis::condition_number(deficient), InternalError);
}

}  // namespace vrda::least_squares_test
