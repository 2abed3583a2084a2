#include "bench/motion_filter.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/units.hpp"
#include "player/bench/moves.hpp"

namespace vrda::one_euro_test {

/// Of the header: 1 / (2 pi cutoff(speed)).
double delay_s(const bench::OneEuroOptions& options, double speed)
{
  return 1.0 / (2.0 * pi * (options.least_cutoff_hz + options.hz_by_speed * speed));
}

TEST(OneEuro, LagsARampByTheStatedDelayAtAnyRate)
{
  // 30 s are 180 times the slowest time constant, 1 / (2 pi 1 Hz) = 0.16 s.
  const bench::OneEuroOptions options{1.0, 5.0, 1.0};
  for (const double rate_hz : {30.0, 100.0, 1000.0}) {
    for (const double speed : {0.0, 0.2, -0.2, 1.5}) {
      SCOPED_TRACE(speed);
      bench::OneEuroFilter filter(options);
      double value = 0.0, time_s = 0.0;
      for (int i = 0; i <= 30 * static_cast<int>(rate_hz); ++i) {
        time_s = i / rate_hz;
        value = filter.filtered(0.7 + speed * time_s, time_s);
      }
      const double lag = 0.7 + speed * time_s - value;
      EXPECT_NEAR(lag, speed * delay_s(options, std::abs(speed)), 1e-9);
    }
  }
}

TEST(OneEuro, AtRestNoiseFallsByTheFirstOrderFilter)
{
  // Without gain the variance of white noise falls to a / (2 - a). The mean square of n values that are
  // correlated over 1 / a steps spreads relatively by sqrt(2 / (a n)); five of that.
  const bench::OneEuroOptions options{1.5, 0.0, 1.0};
  const double step_s = 0.01, a = 1.0 / (1.0 + 1.0 / (2.0 * pi * 1.5 * step_s));
  std::mt19937_64 random(51);
  bench::OneEuroFilter filter(options);
  constexpr int n = 200000;
  double square = 0.0;
  for (int i = 0; i < n; ++i) {
    const double value = filter.filtered(test::noise_of(random, 1.0).x(), i * step_s);
    square += i < 1000 ? 0.0 : value * value / (n - 1000);
  }
  EXPECT_NEAR(square / (a / (2.0 - a)), 1.0, 5.0 * std::sqrt(2.0 / (a * n)));
}

TEST(OneEuro, TimesThatDoNotAscend)
{
  bench::OneEuroFilter filter({1.0, 0.0, 1.0});
  EXPECT_EQ(filter.filtered(1.0, 10.0), 1.0);
  const double second = filter.filtered(2.0, 10.1);
  EXPECT_GT(second, 1.0);
  EXPECT_LT(second, 2.0);
  EXPECT_EQ(filter.filtered(50.0, 10.1), second);
  EXPECT_EQ(filter.filtered(3.0, 4.0), 3.0);
  filter.start_over();
  EXPECT_EQ(filter.filtered(7.0, 4.0), 7.0);
}

}  // namespace vrda::one_euro_test
