#include "job/sampled_case.hpp"

#include <gtest/gtest.h>

#include <set>

namespace vrda::sampling_test {

using job::SampleSequence;

class Sampling : public testing::TestWithParam<SampleSequence> {};

TEST_P(Sampling, seeds)
{
  const Eigen::MatrixXd a = job::unit_samples(GetParam(), 64, 5, 7);
  EXPECT_EQ(a, job::unit_samples(GetParam(), 64, 5, 7));
  EXPECT_NE(a, job::unit_samples(GetParam(), 64, 5, 8));
  EXPECT_GT(a.minCoeff(), 0.0);
  EXPECT_LT(a.maxCoeff(), 1.0);
}

TEST_P(Sampling, intervals)
{
  // True of 2^k points of a Sobol sequence, and of any number of a Latin hypercube.
  const Eigen::Index n = 128;
  const Eigen::MatrixXd samples = job::unit_samples(GetParam(), n, 9, 3);
  for (Eigen::Index d = 0; d < samples.cols(); ++d) {
    std::set<int> intervals;
    for (Eigen::Index s = 0; s < n; ++s)
      intervals.insert(static_cast<int>(samples(s, d) * static_cast<double>(n)));
    EXPECT_EQ(intervals.size(), static_cast<std::size_t>(n)) << "dimension " << d;
  }
}

TEST_P(Sampling, independent_dimensions)
{
  const Eigen::MatrixXd samples = job::unit_samples(GetParam(), 512, 20, 1).array() - 0.5;
  // Of independent uniform numbers the correlation has a standard error of 1 / sqrt(512) = 0.044.
  for (Eigen::Index d = 1; d < samples.cols(); ++d)
    EXPECT_LT(std::abs(12.0 * samples.col(d - 1).dot(samples.col(d)) / 512.0), 4.0 * 0.044) << d;
}

INSTANTIATE_TEST_SUITE_P(BothSequences, Sampling,
                         testing::Values(SampleSequence::sobol, SampleSequence::latin_hypercube));

TEST(Sampling, first_points)
{
  // Of Sobol's only: more samples refine what is there.
  EXPECT_EQ(job::unit_samples(SampleSequence::sobol, 16, 4, 2),
            job::unit_samples(SampleSequence::sobol, 64, 4, 2).topRows(16));
}

}  // namespace vrda::sampling_test
