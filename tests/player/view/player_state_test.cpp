#include "view/player_state.hpp"

#include <gtest/gtest.h>

namespace vrda::player_state_test {

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

TEST(PlayerState, AnotherSetKeepsAttitudeAndPlay)
{
  PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(2.0);
  for (const std::size_t expected : {1u, 2u, 0u}) {
    const PlayerState next = after(state, Action::next_set, sample_range());
    EXPECT_EQ(next.set, expected);
    EXPECT_EQ(after(next, Action::previous_set, sample_range()).set, state.set);
    EXPECT_TRUE(next.timeline.is_playing);
    EXPECT_EQ(next.timeline.flexion_rad, state.timeline.flexion_rad);
    EXPECT_EQ(next.varus_rad, state.varus_rad);
    state = next;
  }
}

TEST(PlayerState, VarusStepsFromTheBalancedOneAndBack)
{
  PlayerState state = after(sample_state(), Action::varus_up, sample_range());
  EXPECT_NEAR(deg_from_rad(wanted_attitude(state, sample_range()).varus_rad), 2.25, 1e-12);
  for (int i = 0; i < 30; ++i) state = after(state, Action::varus_down, sample_range());
  EXPECT_EQ(wanted_attitude(state, sample_range()).varus_rad, rad_from_deg(-5.0));
  state = after(state, Action::varus_balanced, sample_range());
  EXPECT_EQ(wanted_attitude(state, sample_range()).varus_rad, rad_from_deg(1.25));
}

TEST(PlayerState, WhereVarusIsFreeItIsTheSetsOwn)
{
  PlayerRange range = sample_range();
  range.is_varus_free = true;
  PlayerState state = sample_state();
  state.varus_rad = rad_from_deg(-3.0);
  EXPECT_EQ(wanted_attitude(state, range).varus_rad, range.balanced_varus_rad);
  EXPECT_EQ(after(state, Action::varus_up, range).varus_rad, state.varus_rad);
}

TEST(PlayerState, CyclesComeRound)
{
  const PlayerState state = sample_state();
  struct Row {
    Action action;
    int n;
  };
  for (const Row row : {Row{Action::next_mode, 5}, Row{Action::next_loop, 3}, Row{Action::next_backdrop, 3},
                        Row{Action::next_held, 2}}) {
    PlayerState turned = state;
    for (int i = 0; i < row.n; ++i) {
      turned = after(turned, row.action, sample_range());
      const bool is_back = turned.mode == state.mode && turned.timeline.loop == state.timeline.loop &&
                           turned.backdrop == state.backdrop && turned.held == state.held;
      EXPECT_EQ(is_back, i == row.n - 1) << i;
    }
  }
}

TEST(PlayerState, LayersComeAndGoWhereTheJointHasThem)
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
    const PlayerState shown = after(sample_state(), row.action, range);
    EXPECT_EQ(shown.layers.has(row.layer), row.is_there);
    EXPECT_FALSE(after(shown, row.action, range).layers.has(row.layer));
  }
}

TEST(PlayerState, EscapeClosesTheHelpFirst)
{
  const PlayerState helped = after(sample_state(), Action::show_help, sample_range());
  EXPECT_TRUE(helped.shows_help);
  const PlayerState closed = after(helped, Action::leave, sample_range());
  EXPECT_FALSE(closed.shows_help);
  EXPECT_FALSE(closed.is_done);
  EXPECT_TRUE(after(closed, Action::leave, sample_range()).is_done);
  EXPECT_TRUE(after(helped, Action::quit, sample_range()).is_done);
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

}  // namespace vrda::player_state_test
