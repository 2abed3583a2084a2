#include "calibration/fiducial_fit.hpp"

#include <gtest/gtest.h>

#include <random>

#include "coverage.hpp"
#include "support/input_error.hpp"

namespace vrda::scale_fit_test {

using test::input_error;

std::vector<LandmarkDistance> distances_of(double scale)
{
  std::vector<LandmarkDistance> distances = {
      {"condyles", 85.0, 0.0}, {"plateau", 78.0, 0.0}, {"thigh", 410.0, 0.0}, {"shank", 370.0, 0.0}};
  for (LandmarkDistance& d : distances) d.subject_mm = scale * d.model_mm;
  return distances;
}

TEST(ScaleFit, ExactDistancesGiveTheirScale)
{
  const ScaleFit fit = fit_scale(distances_of(0.92), "marks");
  EXPECT_NEAR(fit.scale, 0.92, 1e-15);
  EXPECT_FALSE(fit.is_uneven);
  EXPECT_NEAR(fit.estimate.residual_rms, 0.0, 1e-12);
  EXPECT_EQ(fit.estimate.names.front(), "subject.scale");
  EXPECT_EQ(fit.estimate.dof, 3.0);
}

TEST(ScaleFit, IntervalsAreHonestAndFewAreCalledUneven)
{
  std::mt19937_64 random(21);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uniform_real_distribution<double> scale(0.8, 1.2);
  test::Coverage coverage;
  int n_uneven = 0;
  constexpr int n = 1000;
  for (int bench = 0; bench < n; ++bench) {
    const double truth = scale(random);
    std::vector<LandmarkDistance> distances = distances_of(truth);
    for (LandmarkDistance& d : distances) d.subject_mm += noise(random);
    const ScaleFit fit = fit_scale(distances, "marks");
    coverage.add(fit.estimate, Eigen::VectorXd::Constant(1, fit.scale - truth));
    n_uneven += fit.is_uneven ? 1 : 0;
  }
  coverage.expect_honest();
  EXPECT_LE(n_uneven, n / 1000);  // of a millimetre of noise, as of fingers on skin
}

TEST(ScaleFit, UnevenDistancesAreCalledSo)
{
  std::vector<LandmarkDistance> distances = distances_of(1.0);
  for (LandmarkDistance& d : distances) d.subject_mm *= d.model_mm > 100.0 ? 1.06 : 0.95;
  const ScaleFit fit = fit_scale(distances, "marks");
  EXPECT_TRUE(fit.is_uneven);
  ASSERT_EQ(fit.estimate.remarks.size(), 1U);
  EXPECT_NE(fit.estimate.remarks[0].find("95 % to 106 %"), std::string::npos) << fit.estimate.remarks[0];
}

TEST(ScaleFit, Refuses)
{
  const auto refusal = [](const std::vector<LandmarkDistance>& distances) {
    return input_error([&] { fit_scale(distances, "marks"); });
  };
  std::vector<LandmarkDistance> few = distances_of(1.0);
  few.resize(2);
  EXPECT_EQ(refusal(few).found, "2 distances");
  std::vector<LandmarkDistance> zero = distances_of(1.0);
  zero[1].subject_mm = 0.0;
  EXPECT_EQ(refusal(zero).field, "plateau");
  EXPECT_EQ(refusal(distances_of(0.45)).found, "a scale of 0.45");
  EXPECT_EQ(refusal(distances_of(10.0)).field, "landmarks");
}

}  // namespace vrda::scale_fit_test
