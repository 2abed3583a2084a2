#include "view/player_state.hpp"

#include <gtest/gtest.h>

#include <random>

namespace vrda::player_state_test {

using view::Action;

view::PlayerState sample_state()
{
  view::PlayerState state;
  state.timeline = view::with_range({}, 0.0, rad_from_deg(90.0));
  state.timeline.is_playing = true;
  state.timeline = view::moved_to(state.timeline, rad_from_deg(40.0));
  return state;
}

view::PlayerRange sample_range()
{
  view::PlayerRange range;
  range.n_sets = 3;
  range.first_varus_rad = rad_from_deg(-5.0);
  range.last_varus_rad = rad_from_deg(5.0);
  range.balanced_varus_rad = rad_from_deg(1.25);
  for (const std::string& name : view::layer_names()) range.available.set(*view::layer_named(name), true);
  return range;
}

TEST(PlayerState, AnotherSetKeepsAttitudeAndPlay)
{
  view::PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(2.0);
  for (const std::size_t expected : {1u, 2u, 0u}) {
    const view::PlayerState next = view::apply_action(state, Action::next_set, sample_range());
    EXPECT_EQ(next.set, expected);
    EXPECT_EQ(view::apply_action(next, Action::previous_set, sample_range()).set, state.set);
    EXPECT_TRUE(next.timeline.is_playing);
    EXPECT_EQ(next.timeline.position, state.timeline.position);
    EXPECT_EQ(next.varus_rad, state.varus_rad);
    state = next;
  }
}

TEST(PlayerState, VarusStepsFromTheBalancedOneAndBack)
{
  view::PlayerState state = view::apply_action(sample_state(), Action::varus_up, sample_range());
  EXPECT_NEAR(deg_from_rad(view::wanted_varus_rad(state, sample_range())), 2.25, 1e-12);
  for (int i = 0; i < 30; ++i) state = view::apply_action(state, Action::varus_down, sample_range());
  EXPECT_EQ(view::wanted_varus_rad(state, sample_range()), rad_from_deg(-5.0));
  state = view::apply_action(state, Action::varus_balanced, sample_range());
  EXPECT_EQ(view::wanted_varus_rad(state, sample_range()), rad_from_deg(1.25));
}

TEST(PlayerState, WhereVarusIsFreeItIsTheSetsOwn)
{
  view::PlayerRange range = sample_range();
  range.is_varus_free = true;
  view::PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(-3.0);
  EXPECT_EQ(view::wanted_varus_rad(state, range), range.balanced_varus_rad);
  EXPECT_EQ(view::apply_action(state, Action::varus_up, range).varus_rad, state.varus_rad);
}

TEST(PlayerState, CyclesComeRound)
{
  const view::PlayerState state = sample_state();
  struct Row {
    Action action;
    int n;
  };
  for (const Row row : {Row{Action::next_mode, 5}, Row{Action::next_loop, 3}, Row{Action::next_backdrop, 3},
                        Row{Action::next_fixed_object, 3}}) {
    view::PlayerState turned = state;
    for (int i = 0; i < row.n; ++i) {
      turned = view::apply_action(turned, row.action, sample_range());
      const bool is_back = turned.mode == state.mode && turned.timeline.loop == state.timeline.loop &&
                           turned.backdrop == state.backdrop && turned.fixed_object == state.fixed_object;
      EXPECT_EQ(is_back, i == row.n - 1) << i;
    }
  }
}

TEST(PlayerState, LayersComeAndGoWhereTheJointHasThem)
{
  view::PlayerRange range = sample_range();
  range.available.set(view::Layer::ligaments, false);
  struct Row {
    Action action;
    view::Layer layer;
    bool is_there;
  };
  for (const Row row : {Row{Action::show_contacts, view::Layer::contacts, true},
                        Row{Action::show_normals, view::Layer::normals, true},
                        Row{Action::show_axes, view::Layer::axes, true},
                        Row{Action::show_helical_axis, view::Layer::helical_axis, true},
                        Row{Action::show_gap_map, view::Layer::gap_map, true},
                        Row{Action::show_ligaments, view::Layer::ligaments, false}}) {
    SCOPED_TRACE(view::name_of(row.layer));
    const view::PlayerState shown = view::apply_action(sample_state(), row.action, range);
    EXPECT_EQ(shown.layers.has(row.layer), row.is_there);
    EXPECT_FALSE(view::apply_action(shown, row.action, range).layers.has(row.layer));
  }
}

TEST(PlayerState, EscapeClosesTheHelpFirst)
{
  const view::PlayerState helped = view::apply_action(sample_state(), Action::show_help, sample_range());
  EXPECT_TRUE(helped.shows_help);
  const view::PlayerState closed = view::apply_action(helped, Action::leave, sample_range());
  EXPECT_FALSE(closed.shows_help);
  EXPECT_FALSE(closed.is_done);
  EXPECT_TRUE(view::apply_action(closed, Action::leave, sample_range()).is_done);
  EXPECT_TRUE(view::apply_action(helped, Action::quit, sample_range()).is_done);
}

TEST(PlayerState, KeysOfViewsNameThem)
{
  const std::array wanted{view::View::front,   view::View::back, view::View::medial,
                          view::View::lateral, view::View::top,  view::View::oblique};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Action action = view::action_of({view::key_of(static_cast<char>('1' + static_cast<int>(i)))});
    EXPECT_EQ(view::view_of(action), wanted[i]);
  }
  EXPECT_EQ(view::view_of(Action::quit), std::nullopt);
}

constexpr double rounding_rad = 1e-9;

view::Timeline playing(view::LoopMode loop)
{
  view::Timeline timeline;
  timeline.last = rad_from_deg(90.0);
  timeline.speed_steps_s = 30.0;
  timeline.loop = loop;
  timeline.is_playing = true;
  return timeline;
}

double deg_after(view::LoopMode loop, double elapsed_s)
{
  return deg_from_rad(view::advanced(playing(loop), elapsed_s).position);
}

TEST(Timeline, GoesTheWayOfEachMode)
{
  struct Row {
    double elapsed_s, once_deg, wrap_deg, bounce_deg;
  };
  for (const Row row : {Row{1, 30, 30, 30}, Row{2.5, 75, 75, 75}, Row{4, 90, 30, 60}, Row{5.5, 90, 75, 15},
                        Row{7, 90, 30, 30}, Row{600001, 90, 30, 30}}) {
    SCOPED_TRACE(row.elapsed_s);
    EXPECT_NEAR(deg_after(view::LoopMode::once, row.elapsed_s), row.once_deg, 1e-6);
    EXPECT_NEAR(deg_after(view::LoopMode::wrap, row.elapsed_s), row.wrap_deg, 1e-6);
    EXPECT_NEAR(deg_after(view::LoopMode::bounce, row.elapsed_s), row.bounce_deg, 1e-6);
  }
}

TEST(Timeline, PartsOfATimeLeadWhereTheWholeDoes)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> elapsed(0.0, 2.0);
  for (const view::LoopMode loop : {view::LoopMode::once, view::LoopMode::wrap, view::LoopMode::bounce}) {
    view::Timeline parts = playing(loop);
    double whole_s = 0.0;
    int n_back = 0;
    for (int i = 0; i < 500; ++i) {
      const double part_s = elapsed(random);
      whole_s += part_s;
      parts = view::advanced(parts, part_s);
      n_back += parts.direction < 0 ? 1 : 0;
      EXPECT_GE(parts.position, parts.first);
      EXPECT_LE(parts.position, parts.last);
    }
    EXPECT_NEAR(parts.position, view::advanced(playing(loop), whole_s).position, rounding_rad);
    EXPECT_EQ(n_back > 100, loop == view::LoopMode::bounce);
  }
}

TEST(Timeline, OnceStopsAtTheEndAndBeginsAgain)
{
  const view::Timeline over = view::advanced(playing(view::LoopMode::once), 100.0);
  EXPECT_FALSE(over.is_playing);
  EXPECT_EQ(over.position, over.last);
  const view::Timeline again = view::toggled(over);
  EXPECT_TRUE(again.is_playing);
  EXPECT_EQ(again.position, again.first);
}

TEST(Timeline, PausedOrWithoutARangeItDoesNotAdvance)
{
  view::Timeline paused = view::toggled(playing(view::LoopMode::wrap));
  paused = view::moved_to(paused, rad_from_deg(33.0));
  EXPECT_EQ(view::advanced(paused, 10.0).position, paused.position);
  const view::Timeline point = view::with_range(playing(view::LoopMode::bounce), 0.5, 0.5);
  EXPECT_EQ(view::advanced(point, 10.0).position, 0.5);
}

TEST(Timeline, StepsPauseAndStayInTheRange)
{
  view::Timeline timeline = view::advanced(playing(view::LoopMode::bounce), 1.0);
  timeline = view::stepped(timeline, 1.0);
  EXPECT_FALSE(timeline.is_playing);
  EXPECT_NEAR(deg_from_rad(timeline.position), 31.0, rounding_rad);
  EXPECT_EQ(view::stepped(timeline, 500.0).position, timeline.last);
  EXPECT_EQ(view::stepped(timeline, -500.0).position, timeline.first);
}

TEST(Timeline, OverFramesStepsAndSpeedsCountFrames)
{
  view::Timeline frames;
  frames.axis = view::TimelineAxis::frames;
  frames = view::with_range(frames, 0.0, 99.0);
  for (int n = 1; n <= 99; ++n) {
    frames = view::stepped(frames, 1.0);
    EXPECT_EQ(frames.position, static_cast<double>(n));
  }
  frames = view::moved_to(frames, 0.0);
  frames.is_playing = true;
  EXPECT_EQ(view::advanced(frames, 0.5).position, 0.5 * frames.speed_steps_s);
}

TEST(Timeline, MovingAndAnotherRangeKeepItPlaying)
{
  const view::Timeline moved = view::moved_to(playing(view::LoopMode::wrap), rad_from_deg(80.0));
  EXPECT_TRUE(moved.is_playing);
  const view::Timeline narrower = view::with_range(moved, rad_from_deg(10.0), rad_from_deg(60.0));
  EXPECT_TRUE(narrower.is_playing);
  EXPECT_EQ(narrower.position, rad_from_deg(60.0));
}

TEST(Timeline, SpeedsClimbAndFallThroughTheSameStepsWithinLimits)
{
  view::Timeline timeline = playing(view::LoopMode::wrap);
  const double speed_steps_s = timeline.speed_steps_s;
  EXPECT_EQ(view::slower(view::faster(timeline)).speed_steps_s, speed_steps_s);
  for (int i = 0; i < 30; ++i) timeline = view::faster(timeline);
  EXPECT_EQ(timeline.speed_steps_s, view::fastest_steps_s);
  for (int i = 0; i < 30; ++i) timeline = view::slower(timeline);
  EXPECT_EQ(timeline.speed_steps_s, view::slowest_steps_s);
}

}  // namespace vrda::player_state_test
