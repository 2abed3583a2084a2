#include "analysis/compare.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/noisy_joint.hpp"
#include "core/text.hpp"

namespace vrda::analysis::recommend_test {

using testing::HasSubstr;

constexpr double rounding = 1e-14;

/// Each cell its own block, in a motion that varies far more than any error.
RawEvidence single_cells(std::size_t n)
{
  RawEvidence raw;
  for (std::size_t c = 0; c < n; ++c) raw.block.push_back(static_cast<std::int32_t>(c));
  raw.variance = 1e6;
  return raw;
}

Recommendation recommend(const std::vector<DegreeEvidence>& degrees)
{
  return analysis::recommend(degrees, single_cells(degrees.front().left_out_sq.size()));
}

TEST(Recommend, MatchesTheClosedForm)
{
  // Degree 2 is best. Degree 1 differs by 1, 3, 1, 3: mean 2, spread sqrt(4/3), standard error sqrt(1/3).
  const Recommendation r = recommend({{1, {2.0, 5.0, 4.0, 7.0}}, {2, {1.0, 2.0, 3.0, 4.0}}});
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
  EXPECT_EQ(r.fault, Fault::none);
}

TEST(Recommend, CellsOfABlockAreOneObservation)
{
  // The same differences 1, 1, 3, 3 in two blocks: sums about the mean -2 and 2, sqrt(2 (4 + 4)) / 4 = 1.
  RawEvidence raw = single_cells(4);
  raw.block = {0, 0, 1, 1};
  const Recommendation r = analysis::recommend({{1, {2.0, 3.0, 6.0, 7.0}}, {2, {1.0, 2.0, 3.0, 4.0}}}, raw);
  EXPECT_NEAR(r.ranked[0].standard_error, 1.0, rounding);
  EXPECT_EQ(r.degree, 1) << "2 <= 2 * 1";
}

TEST(Recommend, TakesTheLowestWithinTwoStandardErrors)
{
  // Differences of degree 3 to degree 5: 3, -1, 3, -1: mean 1, standard error sqrt(16/3) / 2 = 1.15.
  const Recommendation r = recommend({{1, {29.0, 29.0, 28.0, 29.0}},
                                      {3, {5.0, 1.0, 5.0, 1.0}},
                                      {4, {2.5, 2.5, 2.0, 2.1}},
                                      {5, {2.0, 2.0, 2.0, 2.0}}});
  EXPECT_EQ(r.degree, 3);
  EXPECT_EQ(r.best_degree, 5);
  EXPECT_THAT(
      r.reason,
      HasSubstr("degree 3: lowest degree whose error of left-out attitudes (1.73 times the perceptible "
                "error) is within two paired standard errors of the best (1.41, degree 5)"));
  EXPECT_THAT(r.reason, HasSubstr("; degree 1 (5.36) is "));
  EXPECT_THAT(r.reason, HasSubstr("contact is not measured"));
}

TEST(Recommend, LeavesOutDegreesThatCannotBeJudged)
{
  const Recommendation r = recommend({{1, {4.0, 3.9}}, {2, {1.0, 1.0}}, {3, {}}});
  EXPECT_EQ(r.degree, 2);
  EXPECT_TRUE(std::isnan(r.ranked[2].error));
  EXPECT_FALSE(r.ranked[2].is_within);
  EXPECT_EQ(r.ranked[2].fault, Fault::not_measurable);
  const Recommendation none = recommend({{1, {}}, {2, {}}});
  EXPECT_EQ(none.degree, -1);
  EXPECT_EQ(none.fault, Fault::not_measurable);
  EXPECT_EQ(none.ranked.size(), 2u);
}

/// Errors that favour the higher degree.
std::vector<DegreeEvidence> two_degrees()
{
  return {{2, {4.0, 4.2, 4.1}}, {5, {1.0, 1.1, 1.0}}};
}

ContactFigures contact_of(double gap_mm, double overlap_mm, int n_poses = 10)
{
  ContactFigures contact;
  contact.n_poses = n_poses;
  contact.largest_gap_mm = gap_mm;
  contact.largest_overlap_mm = overlap_mm;
  return contact;
}

TEST(Recommend, ADegreeWithAFaultIsNotTakenIfAnotherIsOffered)
{
  const struct {
    ContactFigures contact;
    double second_difference;
    Fault fault;
  } rows[] = {{contact_of(0.15, 0.0), 0.0, Fault::gap},
              {contact_of(0.0, 0.15), 0.0, Fault::overlap},
              {contact_of(0.0, 0.0, 9), 0.0, Fault::no_contact},
              {contact_of(0.0, 0.0), 1.1, Fault::rough}};
  for (const auto& row : rows) {
    SCOPED_TRACE(name_of(row.fault));
    std::vector<DegreeEvidence> degrees = two_degrees();
    degrees[0].contact = degrees[1].contact = contact_of(0.145, 0.145);
    degrees[0].second_difference = degrees[1].second_difference = 1.0;
    EXPECT_EQ(recommend(degrees).degree, 5) << "at the limits";
    degrees[1].contact = row.contact;
    degrees[1].second_difference = row.second_difference;
    Recommendation r = recommend(degrees);
    EXPECT_EQ(r.degree, 2);
    EXPECT_EQ(r.best_degree, 2);
    EXPECT_EQ(r.ranked[1].fault, row.fault);
    EXPECT_THAT(r.reason, HasSubstr(std::string("excluded: degree 5 (") + name_of(row.fault) + ")"));
    degrees.erase(degrees.begin());
    if (row.fault == Fault::no_contact) degrees[0].contact = contact_of(0.0, 0.0, 0);
    r = recommend(degrees);
    EXPECT_EQ(r.degree, -1);
    EXPECT_EQ(r.fault, row.fault);
    EXPECT_THAT(r.reason, HasSubstr("of the best, degree 5, "));
  }
}

TEST(Recommend, NoneIfLessThanHalfOfTheVarianceIsPredicted)
{
  RawEvidence raw = single_cells(3);
  raw.variance = 2.05;  // the error of degree 5 is 1.033
  EXPECT_EQ(analysis::recommend(two_degrees(), raw).fault, Fault::unpredicted);
  EXPECT_EQ(analysis::recommend(two_degrees(), raw).degree, -1);
  EXPECT_EQ(analysis::recommend(two_degrees(), raw).best_degree, 5);
  raw.variance = 2.1;
  EXPECT_EQ(analysis::recommend(two_degrees(), raw).degree, 5);
  // An error that cannot be seen is good enough for a motion that hardly varies.
  raw.variance = 0.0;
  EXPECT_EQ(analysis::recommend({{1, {0.9, 0.9, 0.9}}}, raw).degree, 1);
}

constexpr int n_cases = 100;
/// Required: 95 of 100 cases.
constexpr int least_hits = 95;

int recommended(const test::NoisyJoint& joint, const SmoothOptions& smooth = {})
{
  CompareOptions options;
  options.name = "knee.h5";
  options.smooth = smooth;
  return compare(test::noisy_model(joint), options).recommendation.degree;
}

/// Cases of that joint, with noise of n_cases seeds, in which its own degree is recommended.
int n_hits(test::NoisyJoint joint)
{
  int n = 0;
  for (unsigned seed = 1; seed <= n_cases; ++seed) {
    joint.seed = 1000u * static_cast<unsigned>(joint.degree) + seed;
    n += recommended(joint) == joint.degree ? 1 : 0;
  }
  return n;
}

class TrueDegree : public testing::TestWithParam<int> {};

TEST_P(TrueDegree, IsRecommended)
{
  // Every term of the highest degree is 3 standard errors above the noise.
  EXPECT_GE(n_hits({.degree = GetParam(), .noise_mm = 0.02, .significance = 3.0}), least_hits);
  // One column, as where varus is free: a degree adds one term to each of four surfaces.
  EXPECT_GE(
      n_hits({.degree = GetParam(), .noise_mm = 0.02, .significance = 6.0, .n_flexion = 91, .n_varus = 1}),
      least_hits);
  for (const bool is_robust : {false, true})
    EXPECT_EQ(recommended({.degree = GetParam(), .noise_mm = 0.0}, {is_robust}), GetParam());
}

INSTANTIATE_TEST_SUITE_P(OneToEight, TrueDegree, testing::Values(1, 2, 5, 8));

Comparison compared(const store::MotionModel& model)
{
  CompareOptions options;
  options.name = "knee.h5";
  return compare(model, options);
}

/// By the leave-one-out errors of single cells, as if they were independent.
int recommended_by_single_cells(const store::MotionModel& model)
{
  const SmoothInput input = smooth_input(model, "knee.h5");
  std::vector<SmoothFit> fits;
  std::vector<std::vector<store::GridD>> left_out;
  for (int degree = 1; degree <= 12; ++degree) {
    fits.push_back(smooth_fit(input, degree));
    left_out.push_back(fits.back().leave_one_out);
  }
  const std::vector<std::vector<double>> errors_sq = left_out_errors(fits, left_out);
  std::vector<DegreeEvidence> degrees;
  for (std::size_t k = 0; k < fits.size(); ++k) degrees.push_back({fits[k].set.degree, errors_sq[k]});
  return recommend(degrees).degree;
}

/// Surfaces plus value(i, flexion) in every column, mm and degrees.
template <typename Value>
store::MotionModel with_added(store::MotionModel model, const Value& value)
{
  for (store::GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
    for (Eigen::Index i = 0; i < surface->rows(); ++i)
      surface->row(i) += value(i, model.flexion_deg[static_cast<std::size_t>(i)]);
  }
  return model;
}

TEST(RecommendedDegree, AJumpLeavesNone)
{
  const store::MotionModel smooth = test::noisy_model({.degree = 4, .noise_mm = 0.02});
  EXPECT_EQ(compared(smooth).recommendation.degree, 4);
  const store::MotionModel model =
      with_added(smooth, [](Eigen::Index i, double) { return i >= 11 ? 2.0 : 0.0; });
  const Recommendation r = compared(model).recommendation;
  EXPECT_EQ(r.degree, -1);
  EXPECT_EQ(r.fault, Fault::jump);
  EXPECT_THAT(r.reason, HasSubstr("between flexion 30 and 33 degrees, which no polynomial follows"));
  EXPECT_GT(recommended_by_single_cells(model), 0) << "its error alone does not show it";
  const store::MotionModel outlier =
      with_added(smooth, [](Eigen::Index i, double) { return i == 11 ? 2.0 : 0.0; });
  EXPECT_NE(compared(outlier).recommendation.fault, Fault::jump) << "a single flexion";
}

TEST(RecommendedDegree, CorrelatedErrorsAreLeftOutTogether)
{
  // Degree 4 and errors that are averages over 7 x 5 cells, as facets cause: single cells predict their
  // neighbours' errors.
  int n_hits = 0, n_single_hits = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    store::MotionModel model = test::noisy_model(
        {.degree = 4, .noise_mm = 0.02, .significance = 300.0, .n_flexion = 61, .n_varus = 31, .seed = seed});
    test::NormalNumbers numbers(seed);
    for (store::GridD* surface : {&model.tx_mm, &model.ty_mm, &model.tz_mm, &model.theta_deg}) {
      store::GridD noise(67, 35);
      for (double& value : noise.reshaped()) value = 0.3 * numbers.next();
      for (Eigen::Index i = 0; i < 61; ++i) {
        for (Eigen::Index j = 0; j < 31; ++j) (*surface)(i, j) += noise.block(i, j, 7, 5).mean();
      }
    }
    const Recommendation r = compared(model).recommendation;
    EXPECT_GE(r.block_size.flexion, 7);
    EXPECT_GE(r.block_size.varus, 5);
    EXPECT_THAT(r.degree, testing::AnyOf(4, 5));
    n_hits += r.degree == 4 ? 1 : 0;
    n_single_hits += recommended_by_single_cells(model) <= 8 ? 1 : 0;
  }
  // Errors near the edge of a block are still correlated with those outside, so sometimes one degree higher.
  EXPECT_GE(n_hits, 6);
  EXPECT_EQ(n_single_hits, 0);
}

constexpr double two_pi = 6.283185307179586;

TEST(RecommendedDegree, ARoughMotionIsNotTaken)
{
  // A wave of 4 mm and degrees every 30 degrees of flexion, which degree 12 follows: its second difference
  // over a degree is 4 (2 pi / 30)^2 / sqrt(2) = 0.12 mm in each of three directions, together 1.5 times what
  // can be seen. Without the wave half a millimetre per degree of flexion remains.
  const store::MotionModel model = with_added(
      test::noisy_model({.degree = 4, .noise_mm = 0.02, .n_flexion = 31}),
      [](Eigen::Index, double flexion) { return 0.5 * flexion + 4.0 * std::sin(two_pi * flexion / 30.0); });
  const Comparison comparison = compared(model);
  const Recommendation& r = comparison.recommendation;
  ASSERT_GE(r.degree, 1);
  const auto of = [](int degree) { return static_cast<std::size_t>(degree - 1); };
  EXPECT_LE(comparison.rows[of(r.degree)].second_difference, 1.0);
  EXPECT_EQ(r.ranked[of(12)].fault, Fault::rough);
  EXPECT_GT(comparison.rows[of(recommended_by_single_cells(model))].second_difference, 1.5)
      << "its error alone takes the wave";
}

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

}  // namespace vrda::analysis::recommend_test
