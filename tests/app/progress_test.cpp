#include "core/console.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"

namespace vrda::progress_test {

TEST(Progress, RateAndRemainingTime)
{
  EXPECT_EQ(core::rate_text(100, 10.0, 900), "10/s, 1:30 left");
  EXPECT_EQ(core::rate_text(1, 4.0, 1), "0.25/s, 0:04 left");
  EXPECT_EQ(core::rate_text(0, 3.0, 10), "starting");
}

TEST(Progress, AClockThatWasSetSaysNothingAbsurd)
{
  // Hours back, unchanged, and the largest step of a 64-bit clock: 292 years.
  EXPECT_EQ(core::rate_text(5, -7200.0, 10), "starting");
  EXPECT_EQ(core::rate_text(5, 0.0, 10), "starting");
  EXPECT_EQ(core::rate_text(1, 9.2e9, 1'000'000), "1.09e-10/s, 153333333333333:20 left");
}

TEST(Progress, StylesByName)
{
  EXPECT_EQ(core::progress_style_of("bar"), core::ProgressStyle::bar);
  EXPECT_EQ(core::progress_style_of("plain"), core::ProgressStyle::plain);
  EXPECT_EQ(core::progress_style_of("none"), core::ProgressStyle::none);
  try {
    core::progress_style_of("fast");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "--progress: found fast, wanted auto, bar, plain or none");
  }
}

}  // namespace vrda::progress_test
