#include "job/sampled_case.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "job/uncertainty_job.hpp"

namespace vrda::statistics_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Statistics, quantiles)
{
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, nan, 3, 2}, 0.5), 2.5) << "failed samples are left out";
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, 3, 2}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, 3, 2}, 1.0), 4.0);
  EXPECT_TRUE(std::isnan(job::quantile({nan}, 0.5)));
}

TEST(Statistics, rank_correlation)
{
  const std::vector<double> x{1, 2, 3, 4, 5}, cubes{1, 8, 27, 64, 125}, falling{9, 7, 5, 3, 1};
  EXPECT_DOUBLE_EQ(job::rank_correlation(x, cubes), 1.0);
  EXPECT_DOUBLE_EQ(job::rank_correlation(x, falling), -1.0);
  // Ranks 1, 2.5, 2.5, 4 against 1, 2, 3, 4: 4.5 / sqrt(5 * 4.5).
  EXPECT_NEAR(job::rank_correlation(std::vector<double>{1, 2, 2, 3}, std::vector<double>{1, 2, 3, 4}),
              std::sqrt(0.9), 1e-12);
  EXPECT_TRUE(std::isnan(job::rank_correlation(x, std::vector<double>{1, 1, 1, 1, 1})));
}

struct Study {
  Eigen::MatrixXd scores;
  Eigen::MatrixXd result;  // one column
  std::vector<int> group;
};

// y = 3 z0 + 2 (z1^2 - 1) / sqrt(2) + z0 z2: variances 9, 4 and 1.
Study study(std::uint32_t seed, job::SampleSequence sequence)
{
  const Eigen::Index n = 400;
  Study made;
  made.scores = job::unit_samples(sequence, n, 4, seed).unaryExpr(&job::score_of_probability);
  made.result.resize(n, 1);
  for (Eigen::Index s = 0; s < n; ++s) {
    const auto z = made.scores.row(s);
    made.result(s, 0) = 3.0 * z[0] + 2.0 * (z[1] * z[1] - 1.0) / std::sqrt(2.0) + z[0] * z[2];
  }
  made.group = job::jackknife_groups(static_cast<std::size_t>(n), seed);
  return made;
}

TEST(Statistics, first_order_indices)
{
  const Study made = study(1, job::SampleSequence::sobol);
  const double expected[] = {9.0 / 14.0, 4.0 / 14.0, 0.0, 0.0};
  for (Eigen::Index d = 0; d < 4; ++d) {
    const auto index = job::first_order_indices(made.scores.col(d), made.result, made.group).front();
    // The standard error of a share of 0.3 from 400 samples is 0.04.
    EXPECT_NEAR(index.index, expected[d], 0.04) << d;
    EXPECT_LE(index.low, index.index);
    EXPECT_GE(index.high, index.index);
  }
}

TEST(Statistics, intervals)
{
  const double expected[] = {9.0 / 14.0, 4.0 / 14.0};
  int n_held = 0, n_all = 0;
  for (std::uint32_t seed = 1; seed <= 100; ++seed) {
    const Study made = study(seed, job::SampleSequence::latin_hypercube);
    for (Eigen::Index d = 0; d < 2; ++d, ++n_all) {
      const auto index = job::first_order_indices(made.scores.col(d), made.result, made.group).front();
      n_held += index.low <= expected[d] && expected[d] <= index.high ? 1 : 0;
    }
  }
  // 180 of 200 are expected; the standard deviation of independent ones is 4.
  EXPECT_GE(n_held, 180 - 4 * 4) << "of " << n_all;
}

TEST(Statistics, failed_samples)
{
  Study made = study(1, job::SampleSequence::sobol);
  const double whole = job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index;
  for (Eigen::Index s = 0; s < 20; ++s) made.result(s, 0) = nan;
  const double most = job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index;
  EXPECT_NEAR(most, whole, 0.03);
  EXPECT_NE(most, whole);
  made.result.topRows(361).setConstant(nan);
  EXPECT_TRUE(std::isnan(job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index));
  made.result.setConstant(5.0);
  EXPECT_TRUE(std::isnan(job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index))
      << "no spread";
}

}  // namespace vrda::statistics_test
