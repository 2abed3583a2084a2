#include "smooth/singular_values.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <random>

#include "core/error.hpp"

namespace vrda::singular_values_test {

/// Of the largest singular value: sums over a few dozen products.
constexpr double rounding = 1e-13;

Eigen::MatrixXd random_square(Eigen::Index n, std::mt19937_64& generator)
{
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index k = 0; k < A.size(); ++k)
    A.data()[k] = static_cast<double>(generator() % 2001) / 1000.0 - 1.0;
  return A;
}

TEST(SingularRange, OfADiagonalIsItsEnds)
{
  const Eigen::MatrixXd A = Eigen::Vector4d(-3.0, 0.5, 7.0, 2.0).asDiagonal();
  const SingularRange range = singular_range(A);
  EXPECT_NEAR(range.largest, 7.0, 7 * rounding);
  EXPECT_NEAR(range.smallest, 0.5, 7 * rounding);
  const SingularRange one = singular_range(Eigen::MatrixXd::Constant(1, 1, -2.5));
  EXPECT_NEAR(one.largest, 2.5, 7 * rounding);
  EXPECT_NEAR(one.smallest, 2.5, 7 * rounding);
}

TEST(SingularRange, AgreesWithJacobiRotations)
{
  std::mt19937_64 generator(11);
  for (Eigen::Index n = 1; n <= 30; ++n) {
    SCOPED_TRACE(n);
    Eigen::MatrixXd A = random_square(n, generator);
    A.col(n / 2) *= 1e-4;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A);
    const double largest = svd.singularValues()(0);
    const SingularRange range = singular_range(A);
    EXPECT_NEAR(range.largest, largest, largest * rounding);
    EXPECT_NEAR(range.smallest, svd.singularValues()(n - 1), largest * rounding);
  }
}

TEST(SingularRange, OfASingularMatrixEndsAtNothing)
{
  Eigen::MatrixXd A = Eigen::MatrixXd::Ones(5, 5);
  const SingularRange range = singular_range(A);
  EXPECT_NEAR(range.largest, 5.0, 5 * rounding);
  EXPECT_LT(range.smallest, 5 * rounding);
  A.setZero();
  EXPECT_EQ(singular_range(A).largest, 0.0);
  EXPECT_THROW(singular_range(Eigen::MatrixXd::Ones(2, 3)), InternalError);
}

}  // namespace vrda::singular_values_test
