#include "igtl/message.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace vrda::rotation_test {

// Dyadic cosine and sine would not be a rotation; 3-4-5 is one to rounding.
Eigen::Matrix3d rotation()
{
  Eigen::Matrix3d R;
  R << 0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0;
  return R;
}

constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();

TEST(NearestRotation, OfARotationTimesASymmetricMatrixIsTheRotation)
{
  // The polar decomposition is unique: R S with S symmetric and positive gives R back.
  Eigen::Matrix3d S;
  S << 1.0005, 1e-4, -2e-4, 1e-4, 0.9998, 3e-4, -2e-4, 3e-4, 1.0002;
  const std::optional<Eigen::Matrix3d> R = nearest_rotation(rotation() * S);
  ASSERT_TRUE(R);
  EXPECT_LT((*R - rotation()).cwiseAbs().maxCoeff(), rounding);
}

TEST(NearestRotation, RefusesWhatIsNone)
{
  EXPECT_TRUE(nearest_rotation(rotation()));
  EXPECT_FALSE(nearest_rotation(-rotation()));
  EXPECT_FALSE(nearest_rotation(Eigen::Matrix3d::Zero()));
  Eigen::Matrix3d mirrored = rotation();
  mirrored.col(2) *= -1.0;
  EXPECT_FALSE(nearest_rotation(mirrored));
  for (int k = 0; k < 9; ++k) {
    Eigen::Matrix3d matrix = rotation();
    matrix(k) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(nearest_rotation(matrix));
    matrix(k) = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(nearest_rotation(matrix));
    matrix(k) = 1e200;
    EXPECT_FALSE(nearest_rotation(matrix));
  }
}

TEST(NearestRotation, TakesThreeDecimalsAndNoScaleOfAThousandth)
{
  // R^T R - I of a scale 1 + e is 2e.
  EXPECT_TRUE(nearest_rotation((1.0 + 0.49 * most_rotation_error) * rotation()));
  EXPECT_FALSE(nearest_rotation((1.0 + 0.51 * most_rotation_error) * rotation()));
  EXPECT_FALSE(nearest_rotation(1.001 * rotation()));
  Eigen::Matrix3d written;
  written << 0.354, -0.866, 0.354, 0.612, 0.500, 0.612, -0.707, 0.000, 0.707;
  EXPECT_TRUE(nearest_rotation(written));
}

TEST(UnitQuaternion, IsMadeOfUnitLengthOrRefused)
{
  const std::optional<Eigen::Quaterniond> q = unit_quaternion({0.8003, 0.0, 0.6, 0.0});
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->norm(), 1.0, rounding);
  EXPECT_NEAR(q->w() / q->y(), 0.8003 / 0.6, rounding);
  EXPECT_FALSE(unit_quaternion({0.81, 0.0, 0.6, 0.0}));
  EXPECT_FALSE(unit_quaternion(Eigen::Vector4d::Zero()));
  EXPECT_FALSE(unit_quaternion({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.6, 0.0}));
}

}  // namespace vrda::rotation_test
