#include <gtest/gtest.h>

#include "compare/compare.hpp"
#include "compare/noisy_joint.hpp"

namespace vrda::recommended_degree_test {

constexpr int n_cases = 100;
/// Promised: 95 of 100 cases.
constexpr int least_hits = 95;

int recommended(const test::NoisyJoint& joint, const SmoothOptions& smooth = {})
{
  CompareOptions options;
  options.name = "knee.h5";
  options.smooth = smooth;
  return compare(test::noisy_model(joint), options).recommendation.degree;
}

class TrueDegree : public testing::TestWithParam<int> {};

TEST_P(TrueDegree, IsRecommendedUnderNoise)
{
  // Every term of the highest degree stands 3 standard errors above the noise.
  int n_hits = 0;
  for (unsigned seed = 1; seed <= n_cases; ++seed) {
    test::NoisyJoint joint{.degree = GetParam(), .noise_mm = 0.02, .significance = 3.0};
    joint.seed = 1000u * static_cast<unsigned>(GetParam()) + seed;
    n_hits += recommended(joint) == GetParam() ? 1 : 0;
  }
  EXPECT_GE(n_hits, least_hits);
}

TEST_P(TrueDegree, IsRecommendedWithoutNoise)
{
  EXPECT_EQ(recommended({.degree = GetParam(), .noise_mm = 0.0}), GetParam());
  EXPECT_EQ(recommended({.degree = GetParam(), .noise_mm = 0.0}, {.is_robust = true}), GetParam());
}

TEST_P(TrueDegree, IsRecommendedWhereVarusIsFree)
{
  // One column: a degree adds one term to each of four surfaces.
  int n_hits = 0;
  for (unsigned seed = 1; seed <= n_cases; ++seed) {
    test::NoisyJoint joint{
        .degree = GetParam(), .noise_mm = 0.02, .significance = 6.0, .n_flexion = 91, .n_varus = 1};
    joint.seed = 1000u * static_cast<unsigned>(GetParam()) + seed;
    n_hits += recommended(joint) == GetParam() ? 1 : 0;
  }
  EXPECT_GE(n_hits, least_hits);
}

INSTANTIATE_TEST_SUITE_P(OneToEight, TrueDegree, testing::Range(1, 9));

TEST(RecommendedDegree, RobustIsNotMisledByGrossErrors)
{
  // One cell in twenty is off by a hundred times the noise.
  int n_robust = 0, n_plain = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    MotionModel model = test::noisy_model({.degree = 4, .noise_mm = 0.02, .significance = 6.0, .seed = seed});
    test::NormalNumbers numbers(seed);
    for (GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
      for (Eigen::Index k = seed; k < surface->size(); k += 20) surface->data()[k] += 2.0 * numbers.next();
    }
    CompareOptions options;
    options.name = "knee.h5";
    options.degrees = {1, 2, 3, 4, 5, 6, 7, 8};
    n_plain += compare(model, options).recommendation.degree == 4 ? 1 : 0;
    options.smooth.is_robust = true;
    n_robust += compare(model, options).recommendation.degree == 4 ? 1 : 0;
  }
  EXPECT_EQ(n_robust, 10);
  EXPECT_LE(n_plain, 2);
}

}  // namespace vrda::recommended_degree_test
