#include "navigation/player_state.hpp"

#include <gtest/gtest.h>

#include <random>

namespace vrda::player_state_test {

using navigation::Action;

navigation::PlayerState sample_state()
{
  navigation::PlayerState state;
  state.timeline = navigation::with_range({}, 0.0, rad_from_deg(90.0));
  state.timeline.is_playing = true;
  state.timeline = navigation::moved_to(state.timeline, rad_from_deg(40.0));
  return state;
}

navigation::PlayerRange sample_range()
{
  navigation::PlayerRange range;
  range.n_sets = 3;
  range.first_varus_rad = rad_from_deg(-5.0);
  range.last_varus_rad = rad_from_deg(5.0);
  range.balanced_varus_rad = rad_from_deg(1.25);
  for (const std::string& name : scene::layer_names()) range.available.set(*scene::layer_named(name), true);
  return range;
}

TEST(PlayerState, AnotherSetKeepsAttitudeAndPlay)
{
  navigation::PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(2.0);
  for (const std::size_t expected : {1u, 2u, 0u}) {
    const navigation::PlayerState next = navigation::apply_action(state, Action::next_set, sample_range());
    EXPECT_EQ(next.set, expected);
    EXPECT_EQ(navigation::apply_action(next, Action::previous_set, sample_range()).set, state.set);
    EXPECT_TRUE(next.timeline.is_playing);
    EXPECT_EQ(next.timeline.position, state.timeline.position);
    EXPECT_EQ(next.varus_rad, state.varus_rad);
    state = next;
  }
}

TEST(PlayerState, VarusStepsFromTheBalancedOneAndBack)
{
  navigation::PlayerState state = navigation::apply_action(sample_state(), Action::varus_up, sample_range());
  EXPECT_NEAR(deg_from_rad(navigation::wanted_varus_rad(state, sample_range())), 2.25, 1e-12);
  for (int i = 0; i < 30; ++i) state = navigation::apply_action(state, Action::varus_down, sample_range());
  EXPECT_EQ(navigation::wanted_varus_rad(state, sample_range()), rad_from_deg(-5.0));
  state = navigation::apply_action(state, Action::varus_balanced, sample_range());
  EXPECT_EQ(navigation::wanted_varus_rad(state, sample_range()), rad_from_deg(1.25));
}

TEST(PlayerState, WhereVarusIsFreeItIsTheSetsOwn)
{
  navigation::PlayerRange range = sample_range();
  range.is_varus_free = true;
  navigation::PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(-3.0);
  EXPECT_EQ(navigation::wanted_varus_rad(state, range), range.balanced_varus_rad);
  EXPECT_EQ(navigation::apply_action(state, Action::varus_up, range).varus_rad, state.varus_rad);
}

TEST(PlayerState, CyclesComeRound)
{
  const navigation::PlayerState state = sample_state();
  struct Row {
    Action action;
    int n;
  };
  for (const Row row : {Row{Action::next_mode, 5}, Row{Action::next_loop, 3}, Row{Action::next_backdrop, 3},
                        Row{Action::next_fixed_object, 3}}) {
    navigation::PlayerState turned = state;
    for (int i = 0; i < row.n; ++i) {
      turned = navigation::apply_action(turned, row.action, sample_range());
      const bool is_back = turned.mode == state.mode && turned.timeline.loop == state.timeline.loop &&
                           turned.backdrop == state.backdrop && turned.fixed_object == state.fixed_object;
      EXPECT_EQ(is_back, i == row.n - 1) << i;
    }
  }
}

TEST(PlayerState, LayersComeAndGoWhereTheJointHasThem)
{
  navigation::PlayerRange range = sample_range();
  range.available.set(scene::Layer::ligaments, false);
  struct Row {
    Action action;
    scene::Layer layer;
    bool is_there;
  };
  for (const Row row : {Row{Action::show_contacts, scene::Layer::contacts, true},
                        Row{Action::show_normals, scene::Layer::normals, true},
                        Row{Action::show_axes, scene::Layer::axes, true},
                        Row{Action::show_helical_axis, scene::Layer::helical_axis, true},
                        Row{Action::show_gap_map, scene::Layer::gap_map, true},
                        Row{Action::show_ligaments, scene::Layer::ligaments, false}}) {
    SCOPED_TRACE(scene::name_of(row.layer));
    const navigation::PlayerState shown = navigation::apply_action(sample_state(), row.action, range);
    EXPECT_EQ(shown.layers.has(row.layer), row.is_there);
    EXPECT_FALSE(navigation::apply_action(shown, row.action, range).layers.has(row.layer));
  }
}

TEST(PlayerState, EscapeClosesTheHelpFirst)
{
  const navigation::PlayerState helped =
      navigation::apply_action(sample_state(), Action::show_help, sample_range());
  EXPECT_TRUE(helped.shows_help);
  const navigation::PlayerState closed = navigation::apply_action(helped, Action::leave, sample_range());
  EXPECT_FALSE(closed.shows_help);
  EXPECT_FALSE(closed.is_done);
  EXPECT_TRUE(navigation::apply_action(closed, Action::leave, sample_range()).is_done);
  EXPECT_TRUE(navigation::apply_action(helped, Action::quit, sample_range()).is_done);
}

TEST(PlayerState, KeysOfViewsNameThem)
{
  const std::array wanted{scene::View::front,   scene::View::back, scene::View::medial,
                          scene::View::lateral, scene::View::top,  scene::View::oblique};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Action action =
        navigation::action_of({navigation::key_of(static_cast<char>('1' + static_cast<int>(i)))});
    EXPECT_EQ(navigation::view_of(action), wanted[i]);
  }
  EXPECT_EQ(navigation::view_of(Action::quit), std::nullopt);
}

constexpr double rounding_rad = 1e-9;

navigation::Timeline playing(navigation::LoopMode loop)
{
  navigation::Timeline timeline;
  timeline.last = rad_from_deg(90.0);
  timeline.speed_steps_s = 30.0;
  timeline.loop = loop;
  timeline.is_playing = true;
  return timeline;
}

double deg_after(navigation::LoopMode loop, double elapsed_s)
{
  return deg_from_rad(navigation::advanced(playing(loop), elapsed_s).position);
}

TEST(Timeline, GoesTheWayOfEachMode)
{
  struct Row {
    double elapsed_s, once_deg, wrap_deg, bounce_deg;
  };
  for (const Row row : {Row{1, 30, 30, 30}, Row{2.5, 75, 75, 75}, Row{4, 90, 30, 60}, Row{5.5, 90, 75, 15},
                        Row{7, 90, 30, 30}, Row{600001, 90, 30, 30}}) {
    SCOPED_TRACE(row.elapsed_s);
    EXPECT_NEAR(deg_after(navigation::LoopMode::once, row.elapsed_s), row.once_deg, 1e-6);
    EXPECT_NEAR(deg_after(navigation::LoopMode::wrap, row.elapsed_s), row.wrap_deg, 1e-6);
    EXPECT_NEAR(deg_after(navigation::LoopMode::bounce, row.elapsed_s), row.bounce_deg, 1e-6);
  }
}

TEST(Timeline, PartsOfATimeLeadWhereTheWholeDoes)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> elapsed(0.0, 2.0);
  for (const navigation::LoopMode loop :
       {navigation::LoopMode::once, navigation::LoopMode::wrap, navigation::LoopMode::bounce}) {
    navigation::Timeline parts = playing(loop);
    double whole_s = 0.0;
    int n_back = 0;
    for (int i = 0; i < 500; ++i) {
      const double part_s = elapsed(random);
      whole_s += part_s;
      parts = navigation::advanced(parts, part_s);
      n_back += parts.direction < 0 ? 1 : 0;
      EXPECT_GE(parts.position, parts.first);
      EXPECT_LE(parts.position, parts.last);
    }
    EXPECT_NEAR(parts.position, navigation::advanced(playing(loop), whole_s).position, rounding_rad);
    EXPECT_EQ(n_back > 100, loop == navigation::LoopMode::bounce);
  }
}

TEST(Timeline, OnceStopsAtTheEndAndBeginsAgain)
{
  const navigation::Timeline over = navigation::advanced(playing(navigation::LoopMode::once), 100.0);
  EXPECT_FALSE(over.is_playing);
  EXPECT_EQ(over.position, over.last);
  const navigation::Timeline again = navigation::toggled(over);
  EXPECT_TRUE(again.is_playing);
  EXPECT_EQ(again.position, again.first);
}

TEST(Timeline, PausedOrWithoutARangeItDoesNotAdvance)
{
  navigation::Timeline paused = navigation::toggled(playing(navigation::LoopMode::wrap));
  paused = navigation::moved_to(paused, rad_from_deg(33.0));
  EXPECT_EQ(navigation::advanced(paused, 10.0).position, paused.position);
  const navigation::Timeline point = navigation::with_range(playing(navigation::LoopMode::bounce), 0.5, 0.5);
  EXPECT_EQ(navigation::advanced(point, 10.0).position, 0.5);
}

TEST(Timeline, StepsPauseAndStayInTheRange)
{
  navigation::Timeline timeline = navigation::advanced(playing(navigation::LoopMode::bounce), 1.0);
  timeline = navigation::stepped(timeline, 1.0);
  EXPECT_FALSE(timeline.is_playing);
  EXPECT_NEAR(deg_from_rad(timeline.position), 31.0, rounding_rad);
  EXPECT_EQ(navigation::stepped(timeline, 500.0).position, timeline.last);
  EXPECT_EQ(navigation::stepped(timeline, -500.0).position, timeline.first);
}

TEST(Timeline, OverFramesStepsAndSpeedsCountFrames)
{
  navigation::Timeline frames;
  frames.axis = navigation::TimelineAxis::frames;
  frames = navigation::with_range(frames, 0.0, 99.0);
  for (int n = 1; n <= 99; ++n) {
    frames = navigation::stepped(frames, 1.0);
    EXPECT_EQ(frames.position, static_cast<double>(n));
  }
  frames = navigation::moved_to(frames, 0.0);
  frames.is_playing = true;
  EXPECT_EQ(navigation::advanced(frames, 0.5).position, 0.5 * frames.speed_steps_s);
}

TEST(Timeline, MovingAndAnotherRangeKeepItPlaying)
{
  const navigation::Timeline moved =
      navigation::moved_to(playing(navigation::LoopMode::wrap), rad_from_deg(80.0));
  EXPECT_TRUE(moved.is_playing);
  const navigation::Timeline narrower = navigation::with_range(moved, rad_from_deg(10.0), rad_from_deg(60.0));
  EXPECT_TRUE(narrower.is_playing);
  EXPECT_EQ(narrower.position, rad_from_deg(60.0));
}

TEST(Timeline, SpeedsClimbAndFallThroughTheSameStepsWithinLimits)
{
  navigation::Timeline timeline = playing(navigation::LoopMode::wrap);
  const double speed_steps_s = timeline.speed_steps_s;
  EXPECT_EQ(navigation::slower(navigation::faster(timeline)).speed_steps_s, speed_steps_s);
  for (int i = 0; i < 30; ++i) timeline = navigation::faster(timeline);
  EXPECT_EQ(timeline.speed_steps_s, navigation::fastest_steps_s);
  for (int i = 0; i < 30; ++i) timeline = navigation::slower(timeline);
  EXPECT_EQ(timeline.speed_steps_s, navigation::slowest_steps_s);
}

}  // namespace vrda::player_state_test
