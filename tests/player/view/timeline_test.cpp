#include "view/player_state.hpp"

#include <gtest/gtest.h>

#include <random>

namespace vrda::timeline_test {

constexpr double rounding_rad = 1e-9;

Timeline playing(LoopMode loop)
{
  Timeline timeline;
  timeline.last_rad = rad_from_deg(90.0);
  timeline.speed_rad_s = rad_from_deg(30.0);
  timeline.loop = loop;
  timeline.is_playing = true;
  return timeline;
}

double deg_after(LoopMode loop, double elapsed_s)
{
  return deg_from_rad(advanced(playing(loop), elapsed_s).flexion_rad);
}

TEST(Timeline, GoesTheWayOfEachMode)
{
  struct Row {
    double elapsed_s, once_deg, wrap_deg, bounce_deg;
  };
  for (const Row row : {Row{1, 30, 30, 30}, Row{2.5, 75, 75, 75}, Row{4, 90, 30, 60}, Row{5.5, 90, 75, 15},
                        Row{7, 90, 30, 30}, Row{600001, 90, 30, 30}}) {
    SCOPED_TRACE(row.elapsed_s);
    EXPECT_NEAR(deg_after(LoopMode::once, row.elapsed_s), row.once_deg, 1e-6);
    EXPECT_NEAR(deg_after(LoopMode::wrap, row.elapsed_s), row.wrap_deg, 1e-6);
    EXPECT_NEAR(deg_after(LoopMode::bounce, row.elapsed_s), row.bounce_deg, 1e-6);
  }
}

TEST(Timeline, PartsOfATimeLeadWhereTheWholeDoes)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> elapsed(0.0, 2.0);
  for (const LoopMode loop : {LoopMode::once, LoopMode::wrap, LoopMode::bounce}) {
    Timeline parts = playing(loop);
    double whole_s = 0.0;
    int n_back = 0;
    for (int i = 0; i < 500; ++i) {
      const double part_s = elapsed(random);
      whole_s += part_s;
      parts = advanced(parts, part_s);
      n_back += parts.direction < 0 ? 1 : 0;
      EXPECT_GE(parts.flexion_rad, parts.first_rad);
      EXPECT_LE(parts.flexion_rad, parts.last_rad);
    }
    EXPECT_NEAR(parts.flexion_rad, advanced(playing(loop), whole_s).flexion_rad, rounding_rad);
    EXPECT_EQ(n_back > 100, loop == LoopMode::bounce);
  }
}

TEST(Timeline, OnceStopsAtTheEndAndBeginsAgain)
{
  const Timeline over = advanced(playing(LoopMode::once), 100.0);
  EXPECT_FALSE(over.is_playing);
  EXPECT_EQ(over.flexion_rad, over.last_rad);
  const Timeline again = toggled(over);
  EXPECT_TRUE(again.is_playing);
  EXPECT_EQ(again.flexion_rad, again.first_rad);
}

TEST(Timeline, PausedAndRangelessStandStill)
{
  Timeline paused = toggled(playing(LoopMode::wrap));
  paused = moved_to(paused, rad_from_deg(33.0));
  EXPECT_EQ(advanced(paused, 10.0).flexion_rad, paused.flexion_rad);
  const Timeline point = with_range(playing(LoopMode::bounce), 0.5, 0.5);
  EXPECT_EQ(advanced(point, 10.0).flexion_rad, 0.5);
}

TEST(Timeline, StepsPauseAndStayInTheRange)
{
  Timeline timeline = advanced(playing(LoopMode::bounce), 1.0);
  timeline = stepped(timeline, rad_from_deg(1.0));
  EXPECT_FALSE(timeline.is_playing);
  EXPECT_NEAR(deg_from_rad(timeline.flexion_rad), 31.0, rounding_rad);
  EXPECT_EQ(stepped(timeline, rad_from_deg(500.0)).flexion_rad, timeline.last_rad);
  EXPECT_EQ(stepped(timeline, rad_from_deg(-500.0)).flexion_rad, timeline.first_rad);
}

TEST(Timeline, MovingAndAnotherRangeKeepItPlaying)
{
  const Timeline moved = moved_to(playing(LoopMode::wrap), rad_from_deg(80.0));
  EXPECT_TRUE(moved.is_playing);
  const Timeline narrower = with_range(moved, rad_from_deg(10.0), rad_from_deg(60.0));
  EXPECT_TRUE(narrower.is_playing);
  EXPECT_EQ(narrower.flexion_rad, rad_from_deg(60.0));
}

TEST(Timeline, SpeedsClimbAndFallThroughTheSameStepsWithinLimits)
{
  Timeline timeline = playing(LoopMode::wrap);
  const double speed_rad_s = timeline.speed_rad_s;
  EXPECT_EQ(slower(faster(timeline)).speed_rad_s, speed_rad_s);
  for (int i = 0; i < 30; ++i) timeline = faster(timeline);
  EXPECT_EQ(timeline.speed_rad_s, fastest_rad_s);
  for (int i = 0; i < 30; ++i) timeline = slower(timeline);
  EXPECT_EQ(timeline.speed_rad_s, slowest_rad_s);
}

}  // namespace vrda::timeline_test
