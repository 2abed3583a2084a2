#include "simulation/draws.hpp"

#include <gtest/gtest.h>

namespace vrda::draws_test {

TEST(Draws, DependOnWhatTheyAreForAlone)
{
  const auto first = [](std::uint64_t seed, DrawFor purpose, std::uint64_t index) {
    return Draws(seed, purpose, index).uniform();
  };
  const double one = first(1, DrawFor::frame, 5);
  EXPECT_EQ(first(1, DrawFor::frame, 5), one);
  EXPECT_NE(first(2, DrawFor::frame, 5), one);
  EXPECT_NE(first(1, DrawFor::potentiometer, 5), one);
  EXPECT_NE(first(1, DrawFor::frame, 6), one);
}

TEST(Draws, HaveTheirMeanVarianceAndRange)
{
  // n numbers; five standard errors of each mean. Of a sum of twelve uniform numbers the fourth moment is
  // 2.9, so the mean square spreads by sqrt(1.9 / n). First numbers of neighbouring indices count as others.
  constexpr int n = 40000;
  double sum = 0.0, square = 0.0, neighbours = 0.0, before = 0.0, uniform_sum = 0.0;
  for (int i = 0; i < n; ++i) {
    Draws draws(7, DrawFor::frame, static_cast<std::uint64_t>(i));
    const double x = draws.normal();
    ASSERT_LT(std::abs(x), 6.0);
    sum += x;
    square += x * x;
    neighbours += x * before;
    before = x;
    const double u = draws.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    uniform_sum += u;
  }
  EXPECT_NEAR(sum / n, 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(square / n, 1.0, 5.0 * std::sqrt(1.9 / n));
  EXPECT_NEAR(neighbours / n, 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(uniform_sum / n, 0.5, 5.0 / std::sqrt(12.0 * n));
}

}  // namespace vrda::draws_test
