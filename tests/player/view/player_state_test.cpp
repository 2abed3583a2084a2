#include "view/player_state.hpp"

#include <gtest/gtest.h>

#include <random>

namespace vrda::view::player_state_test {

PlayerState sample_state()
{
  PlayerState state;
  state.timeline = with_range({}, 0.0, rad_from_deg(90.0));
  state.timeline.is_playing = true;
  state.timeline = moved_to(state.timeline, rad_from_deg(40.0));
  return state;
}

PlayerRange sample_range()
{
  PlayerRange range;
  range.n_sets = 3;
  range.first_varus_rad = rad_from_deg(-5.0);
  range.last_varus_rad = rad_from_deg(5.0);
  range.balanced_varus_rad = rad_from_deg(1.25);
  for (const std::string& name : layer_names()) range.available.set(*layer_named(name), true);
  return range;
}

TEST(PlayerState, NextSet)
{
  PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(2.0);
  for (const std::size_t expected : {1u, 2u, 0u}) {
    const PlayerState next = apply_action(state, Action::next_set, sample_range());
    EXPECT_EQ(next.set, expected);
    EXPECT_EQ(apply_action(next, Action::previous_set, sample_range()).set, state.set);
    EXPECT_TRUE(next.timeline.is_playing);
    EXPECT_EQ(next.timeline.position, state.timeline.position);
    EXPECT_EQ(next.varus_rad, state.varus_rad);
    state = next;
  }
}

TEST(PlayerState, VarusSteps)
{
  PlayerState state = apply_action(sample_state(), Action::varus_up, sample_range());
  EXPECT_NEAR(deg_from_rad(wanted_varus_rad(state, sample_range())), 2.25, 1e-12);
  for (int i = 0; i < 30; ++i) state = apply_action(state, Action::varus_down, sample_range());
  EXPECT_EQ(wanted_varus_rad(state, sample_range()), rad_from_deg(-5.0));
  state = apply_action(state, Action::varus_balanced, sample_range());
  EXPECT_EQ(wanted_varus_rad(state, sample_range()), rad_from_deg(1.25));
}

TEST(PlayerState, FreeVarus)
{
  PlayerRange range = sample_range();
  range.is_varus_free = true;
  PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(-3.0);
  EXPECT_EQ(wanted_varus_rad(state, range), range.balanced_varus_rad);
  EXPECT_EQ(apply_action(state, Action::varus_up, range).varus_rad, state.varus_rad);
}

TEST(PlayerState, CyclesComeRound)
{
  const PlayerState state = sample_state();
  struct Row {
    Action action;
    int n;
  };
  for (const Row row : {Row{Action::next_mode, 5}, Row{Action::next_loop, 3}, Row{Action::next_backdrop, 3},
                        Row{Action::next_fixed_object, 3}}) {
    PlayerState turned = state;
    for (int i = 0; i < row.n; ++i) {
      turned = apply_action(turned, row.action, sample_range());
      const bool is_back = turned.mode == state.mode && turned.timeline.loop == state.timeline.loop &&
                           turned.backdrop == state.backdrop && turned.fixed_object == state.fixed_object;
      EXPECT_EQ(is_back, i == row.n - 1) << i;
    }
  }
}

TEST(PlayerState, Layers)
{
  PlayerRange range = sample_range();
  range.available.set(Layer::ligaments, false);
  struct Row {
    Action action;
    Layer layer;
    bool is_there;
  };
  for (const Row row :
       {Row{Action::show_contacts, Layer::contacts, true}, Row{Action::show_normals, Layer::normals, true},
        Row{Action::show_axes, Layer::axes, true}, Row{Action::show_helical_axis, Layer::helical_axis, true},
        Row{Action::show_gap_map, Layer::gap_map, true},
        Row{Action::show_ligaments, Layer::ligaments, false}}) {
    SCOPED_TRACE(name_of(row.layer));
    const PlayerState shown = apply_action(sample_state(), row.action, range);
    EXPECT_EQ(shown.layers.has(row.layer), row.is_there);
    EXPECT_FALSE(apply_action(shown, row.action, range).layers.has(row.layer));
  }
}

TEST(PlayerState, Escape)
{
  const PlayerState helped = apply_action(sample_state(), Action::show_help, sample_range());
  EXPECT_TRUE(helped.shows_help);
  const PlayerState closed = apply_action(helped, Action::leave, sample_range());
  EXPECT_FALSE(closed.shows_help);
  EXPECT_FALSE(closed.is_done);
  EXPECT_TRUE(apply_action(closed, Action::leave, sample_range()).is_done);
  EXPECT_TRUE(apply_action(helped, Action::quit, sample_range()).is_done);
}

TEST(PlayerState, KeysOfViewsNameThem)
{
  const std::array wanted{View::front, View::back, View::medial, View::lateral, View::top, View::oblique};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Action action = action_of({key_of(static_cast<char>('1' + static_cast<int>(i)))});
    EXPECT_EQ(view_of(action), wanted[i]);
  }
  EXPECT_EQ(view_of(Action::quit), std::nullopt);
}

constexpr double rounding_rad = 1e-9;

Timeline playing(LoopMode loop)
{
  Timeline timeline;
  timeline.last = rad_from_deg(90.0);
  timeline.speed_steps_s = 30.0;
  timeline.loop = loop;
  timeline.is_playing = true;
  return timeline;
}

double deg_after(LoopMode loop, double elapsed_s)
{
  return deg_from_rad(advanced(playing(loop), elapsed_s).position);
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

TEST(Timeline, TimeInParts)
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
      EXPECT_GE(parts.position, parts.first);
      EXPECT_LE(parts.position, parts.last);
    }
    EXPECT_NEAR(parts.position, advanced(playing(loop), whole_s).position, rounding_rad);
    EXPECT_EQ(n_back > 100, loop == LoopMode::bounce);
  }
}

TEST(Timeline, Once)
{
  const Timeline over = advanced(playing(LoopMode::once), 100.0);
  EXPECT_FALSE(over.is_playing);
  EXPECT_EQ(over.position, over.last);
  const Timeline again = toggled(over);
  EXPECT_TRUE(again.is_playing);
  EXPECT_EQ(again.position, again.first);
}

TEST(Timeline, Steps)
{
  Timeline timeline = advanced(playing(LoopMode::bounce), 1.0);
  timeline = stepped(timeline, 1.0);
  EXPECT_FALSE(timeline.is_playing);
  EXPECT_NEAR(deg_from_rad(timeline.position), 31.0, rounding_rad);
  EXPECT_EQ(stepped(timeline, 500.0).position, timeline.last);
  EXPECT_EQ(stepped(timeline, -500.0).position, timeline.first);
}

// Speeds climb and fall through the same steps within limits.
TEST(Timeline, Speeds)
{
  Timeline timeline = playing(LoopMode::wrap);
  const double speed_steps_s = timeline.speed_steps_s;
  EXPECT_EQ(slower(faster(timeline)).speed_steps_s, speed_steps_s);
  for (int i = 0; i < 30; ++i) timeline = faster(timeline);
  EXPECT_EQ(timeline.speed_steps_s, fastest_steps_s);
  for (int i = 0; i < 30; ++i) timeline = slower(timeline);
  EXPECT_EQ(timeline.speed_steps_s, slowest_steps_s);
}

}  // namespace vrda::view::player_state_test
