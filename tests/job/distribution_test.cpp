#include "job/uncertainty_job.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace vrda::distribution_test {

using job::Distribution;
using job::DistributionKind;

TEST(Distribution, closed_forms)
{
  const Distribution normal{.kind = DistributionKind::normal, .mean = 2.0, .sd = 0.5};
  EXPECT_NEAR(job::quantile_of(normal, 0.5), 2.0, 1e-15);
  EXPECT_NEAR(job::quantile_of(normal, 0.95), 2.0 + 0.5 * 1.6448536269514722, 1e-12);
  const Distribution lognormal{.kind = DistributionKind::lognormal, .mean = 3.0, .sd = 0.2};
  EXPECT_NEAR(job::quantile_of(lognormal, 0.05), 3.0 * std::exp(-0.2 * 1.6448536269514722), 1e-12);
  const Distribution uniform{.kind = DistributionKind::uniform, .from = -1.0, .to = 3.0};
  EXPECT_DOUBLE_EQ(job::quantile_of(uniform, 0.25), 0.0);
  const Distribution table{.kind = DistributionKind::table, .values = {1.0, 2.0, 10.0}};
  EXPECT_DOUBLE_EQ(job::quantile_of(table, 0.25), 1.5);
  EXPECT_DOUBLE_EQ(job::quantile_of(table, 0.75), 6.0);
}

TEST(Distribution, truncated)
{
  const Distribution normal{.kind = DistributionKind::normal, .mean = 1.0, .sd = 1.0};
  EXPECT_GT(job::quantile_above(normal, 1e-9, 0.0), 0.0);
  // P(x < q | x > 0) = (F(q) - F(0)) / (1 - F(0)).
  const double q = job::quantile_above(normal, 0.3, 0.0);
  const double below_0 = job::probability_of_score(-1.0);
  EXPECT_NEAR((job::probability_of_score(q - 1.0) - below_0) / (1.0 - below_0), 0.3, 1e-12);
  const Distribution table{.kind = DistributionKind::table, .values = {0.0, 1.0, 2.0}};
  EXPECT_DOUBLE_EQ(job::quantile_above(table, 0.5, 1.0), 1.5);
  const Distribution uniform{.kind = DistributionKind::uniform, .from = 0.0, .to = 1.0};
  EXPECT_DOUBLE_EQ(job::quantile_above(uniform, 0.5, 0.5), 0.75);
  EXPECT_DOUBLE_EQ(job::quantile_above(uniform, 0.5, -3.0), 0.5) << "nothing is cut off";
}

}  // namespace vrda::distribution_test
