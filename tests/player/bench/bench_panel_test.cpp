// The operator's panel of the bench: its next step, its place and that its texts fit.
#include <gtest/gtest.h>

#include "bench/bench_show.hpp"
#include "player/bench/bench_samples.hpp"
#include "player/bench/bench_texts.hpp"

namespace vrda::bench_panel_test {

TEST(BenchPanel, SaysTheNextStepUntilTheBenchIsReady)
{
  bench::BenchFrame frame;
  frame.stage.is_used = true;
  bench::PanelContent content;
  content.is_calibrated = false;
  EXPECT_EQ(bench::next_step_text(frame, content), "next: 1 start the tracker");
  content.tracker.link = bench::LinkState::up;
  EXPECT_EQ(bench::next_step_text(frame, content), "next: 2 zero the stage: move it to its stop, press Z");
  frame.stage.state = bench::ToolVisibility::seen;
  frame.stage.was_seen = frame.stage.is_live = frame.is_stage_zeroed = true;
  EXPECT_EQ(bench::next_step_text(frame, content), "next: 3 calibrate: vrda-player calibrate all");
  content.is_calibrated = true;
  EXPECT_EQ(bench::next_step_text(frame, content), "");
  frame.stage_has_lost_counts = true;
  EXPECT_EQ(bench::next_step_text(frame, content), "next: 2 zero the stage: move it to its stop, press Z");
}

// Everything that the panel can say at once, in sentences longer than it is wide.
bench::PanelContent long_content(const bench::BenchTiming& timing)
{
  std::string sentence;
  for (int k = 0; k < 12; ++k) sentence += "the tracker sends a body that is in no bench file ";
  bench::PanelContent content;
  content.is_calibrated = false;
  content.has_board = true;
  content.error_message = content.message = sentence;
  content.tracker.error_message = content.board.error_message = sentence;
  content.tracker.notes = {sentence, std::string(300, 'w')};
  content.timing = &timing;
  return content;
}

TEST(BenchPanel, FitsBesideTheEyesWindows)
{
  const bench::BenchTiming timing;
  for (const char* layout : {"width = 1280\nheight = 1024\nlayout = \"quarters\"\n",
                             "width = 1600\nheight = 900\nlayout = \"quarters\"\n"}) {
    const test::SmallBench small(test::bench_head() + "[display]\n" + layout + test::tracker_table +
                                 test::two_bodies + test::board_table);
    const std::optional<view::Viewport> area = bench::operator_area(small.bench.display);
    ASSERT_TRUE(area) << layout;
    for (const view::Viewport& eye : {small.bench.display.windows.left, small.bench.display.windows.right}) {
      const bool is_beside = area->x + area->width <= eye.x || eye.x + eye.width <= area->x ||
                             area->y + area->height <= eye.y || eye.y + eye.height <= area->y;
      EXPECT_TRUE(is_beside) << layout;
    }
    bench::BenchPanel panel(small.bench);
    for (const bool has_help : {false, true}) {
      bench::PanelContent content = long_content(timing);
      content.has_help = has_help;
      // Marks in the eyes' views come last: those of a panel that is off are left out of the count.
      content.has_panel = !has_help;
      const view::Overlay with = panel.drawn(small.state, {}, content);
      content.has_panel = content.has_help = false;
      const std::size_t n_marks = panel.drawn(small.state, {}, content).vertices.size();
      ASSERT_GT(with.vertices.size(), n_marks + 100);
      for (std::size_t k = 0; k < with.vertices.size() - n_marks; ++k) {
        const view::OverlayVertex& v = with.vertices[k];
        ASSERT_GE(v.x_px, static_cast<float>(area->x));
        ASSERT_LE(v.x_px, static_cast<float>(area->x + area->width)) << has_help;
        ASSERT_GE(v.y_px, static_cast<float>(area->y));
        ASSERT_LE(v.y_px, static_cast<float>(area->y + area->height)) << has_help << layout;
      }
    }
  }
}

}  // namespace vrda::bench_panel_test
