#include "bench/window_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "player/bench/bench_texts.hpp"
#include "support/refusal.hpp"

namespace vrda::window_check_test {

using testing::HasSubstr;

const std::vector<view::Monitor> two_monitors{{"DP-1", {0, 0, 1280, 1024}, 60},
                                              {"HDMI-1", {1280, 0, 1920, 1080}, 60}};

bench::BenchFile bench_with(const std::string& display)
{
  return test::bench_of(test::bench_head() + "[display]\n" + display + test::tracker_table +
                        test::two_bodies + test::board_table);
}

/// What is found of a window, or nothing.
std::string found(const bench::BenchFile& bench, const view::WindowGeometry& place,
                  const std::vector<view::Monitor>& monitors = two_monitors)
{
  const std::optional<InputError::Facts> facts = bench::window_mismatch(bench, place, monitors);
  return facts ? facts->found : "";
}

TEST(WindowCheck, NamesSizePlaceAndWhatNoScreenShows)
{
  const bench::BenchFile bench =
      bench_with("width = 1280\nheight = 1024\nlayout = \"quarters\"\nat = [0, 0]\n");
  EXPECT_EQ(found(bench, {0, 0, 1280, 1024}), "");
  EXPECT_EQ(found(bench, {0, 0, 1280, 996}), "a frame buffer of 1280 x 996");
  EXPECT_EQ(found(bench, {10, 37, 1280, 1024}), "a window at 10, 37");
  bench::BenchFile elsewhere = bench;
  elsewhere.display.at = {5000, 0};
  EXPECT_EQ(found(elsewhere, {5000, 0, 1280, 1024}), "a window off every screen (1280 x 1024 at 5000, 0)");
  elsewhere.display.at = {-640, 0};
  EXPECT_THAT(found(elsewhere, {-640, 0, 1280, 1024}), HasSubstr("partly off the screens"));
  elsewhere.display.at = {640, 0};
  EXPECT_EQ(found(elsewhere, {640, 0, 1280, 1024}), "") << "across two monitors";
  elsewhere.display.at.reset();
  EXPECT_THAT(found(elsewhere, {0, 2000, 1280, 1024}), HasSubstr("off every screen"))
      << "without a wanted place";
  EXPECT_EQ(found(elsewhere, {0, 2000, 1280, 1024}, {}), "") << "no monitor is known";
}

TEST(WindowCheck, OfMonitorsThatShowTheSameOneCounts)
{
  const bench::BenchFile bench = bench_with("width = 1280\nheight = 1024\nlayout = \"quarters\"\n");
  const std::vector<view::Monitor> copies{{"A", {0, 0, 1280, 1024}, 60}, {"B", {0, 0, 1280, 1024}, 60}};
  EXPECT_THAT(found(bench, {640, 0, 1280, 1024}, copies), HasSubstr("partly"));
}

TEST(Outputs, AreMonitorsByName)
{
  const bench::BenchFile one =
      bench_with("width = 1920\nheight = 1080\nlayout = \"side-by-side\"\noutputs = [\"HDMI-1\"]\n");
  EXPECT_EQ(bench::window_position(one, two_monitors), (std::array{1280, 0}));
  EXPECT_EQ(found(one, {1280, 0, 1920, 1080}), "");
  EXPECT_EQ(found(one, {0, 0, 1920, 1080}), "a window at 0, 0");
  EXPECT_EQ(found(one, {1280, 0, 1920, 1080}, {}), "\"HDMI-1\"") << "unplugged";
  const bench::BenchFile both =
      bench_with("width = 2560\nheight = 1024\nlayout = \"two-outputs\"\noutputs = [\"DP-1\", \"HDMI-1\"]\n");
  EXPECT_EQ(bench::window_position(both, two_monitors), (std::array{0, 0}));
  bench::BenchFile exchanged = both;
  std::swap(exchanged.display.outputs[0], exchanged.display.outputs[1]);
  const InputError::Facts facts = test::input_error([&] { bench::window_position(exchanged, two_monitors); });
  EXPECT_EQ(facts.field, "display.outputs");
  EXPECT_EQ(facts.found, "\"DP-1\" at 0, 0");
  EXPECT_THAT(facts.wanted, HasSubstr("at 2560, 0"));
  exchanged.display.outputs[0] = "VGA-9";
  EXPECT_THAT(test::input_error([&] { bench::window_position(exchanged, two_monitors); }).wanted,
              "one of DP-1, HDMI-1");
}

}  // namespace vrda::window_check_test
