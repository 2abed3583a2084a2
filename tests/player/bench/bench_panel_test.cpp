// Pixels of the operator's panel and of the marks.
#include "bench/bench_show.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "bench_samples.hpp"

namespace vrda::bench_panel_test {

using test::ms_in_ns;
using Colour = std::array<int, 3>;

constexpr int width = 1280, height = 1024;
constexpr Colour paper{24, 27, 32}, green{96, 200, 120}, amber{255, 176, 46};

Colour pixel(const view::Image& image, int x, int y)
{
  const std::size_t i = 4 * static_cast<std::size_t>(y * image.width + x);
  return {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]};
}

/// Longest run of a colour in a column; runs of letters are short.
int longest_run(const view::Image& image, int x, const Colour& colour)
{
  int longest = 0, run = 0;
  for (int y = 0; y < image.height; ++y) {
    run = pixel(image, x, y) == colour ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

/// Pixels of an area with exactly that colour.
int n_of(const view::Image& image, const view::Viewport& part, const Colour& colour)
{
  int n = 0;
  for (int y = part.y; y < part.y + part.height; ++y)
    for (int x = part.x; x < part.x + part.width; ++x) n += pixel(image, x, y) == colour ? 1 : 0;
  return n;
}

/// Pixels of an area covered by amber text, including anti-aliased edges.
int n_amber_in(const view::Image& image, const view::Viewport& part)
{
  constexpr int clearly = 60;  // more red than blue; nothing else on the panel has more red
  int n = 0;
  for (int y = part.y; y < part.y + part.height; ++y)
    for (int x = part.x; x < part.x + part.width; ++x) {
      const Colour colour = pixel(image, x, y);
      n += colour[0] - colour[2] > clearly ? 1 : 0;
    }
  return n;
}

/// A rigid leg in quarters of 1280 x 1024, all inputs live.
class Panel : public testing::Test {
 protected:
  Panel() : panel_(bench_.bench), renderer_(view::make_offscreen_renderer({width, height, 1}))
  {
    nothing_.background = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    renderer_->load(nothing_);
    renderer_->load(panel_.font());
    bench_.state.take(test::place_sample(0, test::some_pose(1), 0, ms_in_ns));
    bench_.state.take(test::potentiometer_sample(0, ms_in_ns));
    bench_.state.take(test::stage_sample(0, ms_in_ns, bench::stage_zeroed));
    content_.tracker.link = content_.board.link = bench::LinkState::up;
    content_.has_board = true;
  }
  const view::Image& picture()
  {
    return renderer_->draw(nothing_, {}, &panel_.drawn(bench_.state, bench_.state.frame(ms_in_ns), content_));
  }

  const view::Viewport operators_{0, 0, 640, height}, left_{640, 16, 640, 480}, right_{640, 528, 640, 480};
  test::SmallBench bench_{test::rigid_text()};
  bench::BenchPanel panel_;
  view::Scene nothing_;
  std::unique_ptr<view::Renderer> renderer_;
  bench::PanelContent content_;
};

TEST_F(Panel, TheHistogramsBarsAreAsTallAsTheirTimesAreMany)
{
  bench::BenchTiming timing;
  content_.timing = &timing;
  for (int k = 0; k < 100; ++k) timing.latency.add(5.5);
  for (int k = 0; k < 50; ++k) timing.latency.add(20.2);
  for (int k = 0; k < 25; ++k) timing.latency.add(40.9);
  timing.latency.add(240.0);
  const view::Image& image = picture();
  // 50 bars of 1 ms between margins of 12 px; the highest has 90 px.
  const auto middle_of = [](int bar) { return static_cast<int>(12.0 + 616.0 / 50.0 * (bar + 0.5)); };
  EXPECT_NEAR(longest_run(image, middle_of(5), green), 90, 1);
  EXPECT_NEAR(longest_run(image, middle_of(20), green), 45, 1);
  // Longer than a frame at 30 Hz.
  EXPECT_NEAR(longest_run(image, middle_of(40), amber), 22.5, 1);
  // A non-empty bar is visible; longer times are in the last bar.
  EXPECT_GE(longest_run(image, middle_of(49), amber), 1);
  for (const int bar : {25, 30, 45}) {
    EXPECT_EQ(longest_run(image, middle_of(bar), green), 0) << bar;
    EXPECT_EQ(longest_run(image, middle_of(bar), amber), 0) << bar;
  }
}

TEST_F(Panel, IsBesideTheEyesWindowsAndOnlyWhereItIsWanted)
{
  const view::Image& with = picture();
  EXPECT_GT(n_of(with, operators_, paper), 640 * height / 2);
  EXPECT_EQ(n_of(with, left_, paper) + n_of(with, right_, paper), 0);
  content_.has_panel = false;
  EXPECT_EQ(n_of(picture(), {0, 0, width, height}, {0, 0, 0}), width * height);
}

TEST_F(Panel, WhatIsNotLiveOrHasNoZeroIsMarkedBeforeBothEyes)
{
  const auto n_amber = [&](const view::Viewport& part) { return n_amber_in(picture(), part); };
  EXPECT_EQ(n_amber(left_) + n_amber(right_), 0);
  bench_.state.take(test::stage_sample(0, ms_in_ns, 0));
  const int n_stage = n_amber(left_);
  EXPECT_GT(n_stage, 50);
  EXPECT_EQ(n_amber(right_), n_stage);
  bench_.state.take(test::hidden_sample(0, ms_in_ns));
  const int n_hidden = n_amber(left_);
  EXPECT_GT(n_hidden, n_stage);
  content_.doubt = view::DoubtText{"dislocated: ..."};
  EXPECT_GT(n_amber(left_), n_hidden);
}

TEST_F(Panel, AnErrorOfTheDisplayIsALineOfThePanel)
{
  EXPECT_EQ(n_amber_in(picture(), operators_), 0);
  content_.error_message = "found a frame buffer of 600 x 500, wanted 1280 x 1024";
  EXPECT_GT(n_amber_in(picture(), operators_), 50);
}

TEST(JointText, NamesTheDirectionsInsteadOfSigns)
{
  ClinicalCoordinates joint;
  joint.internal_rotation_rad = rad_from_deg(9.2);
  joint.anterior_mm = 3.1;
  EXPECT_EQ(bench::joint_text(joint), "internal rotation 9.2 deg, anterior 3.1 mm");
  joint.internal_rotation_rad = rad_from_deg(-0.5);
  joint.anterior_mm = -12.0;
  EXPECT_EQ(bench::joint_text(joint), "external rotation 0.5 deg, posterior 12 mm");
}

}  // namespace vrda::bench_panel_test
