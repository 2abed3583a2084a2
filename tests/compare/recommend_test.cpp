#include "compare/recommend.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compare/compare.hpp"
#include "compare/noisy_joint.hpp"
#include "core/error.hpp"

namespace vrda::recommend_test {

using testing::HasSubstr;

constexpr double rounding = 1e-14;

TEST(Recommend, MatchesTheClosedForm)
{
  // Degree 2 is best. Degree 1 differs by 1, 3, 1, 3: mean 2, spread sqrt(4/3), standard error sqrt(1/3).
  const compare::Recommendation r =
      compare::recommend({{1, {2.0, 5.0, 4.0, 7.0}}, {2, {1.0, 2.0, 3.0, 4.0}}});
  ASSERT_EQ(r.ranked.size(), 2u);
  EXPECT_NEAR(r.ranked[0].error, std::sqrt(4.5), rounding);
  EXPECT_NEAR(r.ranked[0].excess_sq, 2.0, rounding);
  EXPECT_NEAR(r.ranked[0].standard_error, std::sqrt(1.0 / 3.0), rounding);
  EXPECT_FALSE(r.ranked[0].is_within) << "2 > 2 sqrt(1/3)";
  EXPECT_EQ(r.ranked[1].excess_sq, 0.0);
  EXPECT_EQ(r.ranked[1].standard_error, 0.0);
  EXPECT_TRUE(r.ranked[1].is_within);
  EXPECT_EQ(r.degree, 2);
  EXPECT_EQ(r.best_degree, 2);
}

TEST(Recommend, TakesTheLowestWithinTwoStandardErrors)
{
  // Differences of degree 3 to degree 5: 3, -1, 3, -1: mean 1, standard error sqrt(16/3) / 2 = 1.15.
  const compare::Recommendation r = compare::recommend({{1, {29.0, 29.0, 28.0, 29.0}},
                                                        {3, {5.0, 1.0, 5.0, 1.0}},
                                                        {4, {2.5, 2.5, 2.0, 2.1}},
                                                        {5, {2.0, 2.0, 2.0, 2.0}}});
  EXPECT_EQ(r.degree, 3);
  EXPECT_EQ(r.best_degree, 5);
  EXPECT_THAT(
      r.reason,
      HasSubstr("degree 3: lowest degree whose leave-one-out error (1.73 times the perceptible error) is "
                "within two paired standard errors of the best (1.41, degree 5)"));
  EXPECT_THAT(r.reason, HasSubstr("; degree 1 (5.36) is "));
}

TEST(Recommend, SaysWhenTheErrorStillFalls)
{
  const compare::Recommendation r = compare::recommend({{2, {4.0, 4.1, 4.0}}, {3, {1.0, 1.0, 1.0}}});
  EXPECT_EQ(r.degree, 3);
  EXPECT_THAT(r.reason, HasSubstr("smallest leave-one-out error"));
  EXPECT_THAT(r.reason, HasSubstr("still decreases at the highest compared degree"));
}

TEST(Recommend, SaysWhenALowerDegreeIsWorseEverywhere)
{
  const compare::Recommendation r = compare::recommend({{2, {4.0, 4.0}}, {3, {1.0, 1.0}}, {4, {2.0, 2.0}}});
  EXPECT_EQ(r.degree, 3);
  EXPECT_THAT(r.reason, HasSubstr("degree 2 is worse at every cell"));
}

TEST(Recommend, RoundingIsNoReason)
{
  const compare::Recommendation r =
      compare::recommend({{1, {1.0, 1.0}}, {2, {1e-20, 1e-20}}, {3, {1e-28, 1e-28}}});
  EXPECT_EQ(r.degree, 2);
  EXPECT_EQ(r.best_degree, 2);
}

TEST(Recommend, LeavesOutDegreesThatCannotBeJudged)
{
  const compare::Recommendation r = compare::recommend({{1, {4.0, 3.9}}, {2, {1.0, 1.0}}, {3, {}}});
  EXPECT_EQ(r.degree, 2);
  EXPECT_TRUE(std::isnan(r.ranked[2].error));
  EXPECT_FALSE(r.ranked[2].is_within);
  const compare::Recommendation none = compare::recommend({{1, {}}, {2, {}}});
  EXPECT_EQ(none.degree, -1);
  EXPECT_EQ(none.ranked.size(), 2u);
  EXPECT_THAT(none.reason, HasSubstr("no degree"));
}

TEST(Recommend, KeepsItsPromises)
{
  EXPECT_THROW(compare::recommend({{2, {1.0}}, {1, {1.0}}}), InternalError);
  EXPECT_THROW(compare::recommend({{1, {1.0}}, {2, {1.0, 2.0}}}), InternalError);
}

constexpr int n_cases = 100;
/// Required: 95 of 100 cases.
constexpr int least_hits = 95;

int recommended(const test::NoisyJoint& joint, const smooth::SmoothOptions& smooth = {})
{
  compare::CompareOptions options;
  options.name = "knee.h5";
  options.smooth = smooth;
  return compare::compare(test::noisy_model(joint), options).recommendation.degree;
}

class TrueDegree : public testing::TestWithParam<int> {};

TEST_P(TrueDegree, IsRecommendedUnderNoise)
{
  // Every term of the highest degree is 3 standard errors above the noise.
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
    store::MotionModel model =
        test::noisy_model({.degree = 4, .noise_mm = 0.02, .significance = 6.0, .seed = seed});
    test::NormalNumbers numbers(seed);
    for (store::GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
      for (Eigen::Index k = seed; k < surface->size(); k += 20) surface->data()[k] += 2.0 * numbers.next();
    }
    compare::CompareOptions options;
    options.name = "knee.h5";
    options.degrees = {1, 2, 3, 4, 5, 6, 7, 8};
    n_plain += compare::compare(model, options).recommendation.degree == 4 ? 1 : 0;
    options.smooth.is_robust = true;
    n_robust += compare::compare(model, options).recommendation.degree == 4 ? 1 : 0;
  }
  EXPECT_EQ(n_robust, 10);
  EXPECT_LE(n_plain, 2);
}

}  // namespace vrda::recommend_test
