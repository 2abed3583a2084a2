#include "view/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace vrda::keys_test {

TEST(Keys, DoWhatTheIssueSays)
{
  struct Row {
    view::Key key;
    view::Action plain, with_shift;
  };
  for (const Row row : {Row{view::Key::space, view::Action::play_pause, view::Action::play_pause},
                        Row{view::Key::right, view::Action::step_forward, view::Action::leap_forward},
                        Row{view::Key::left, view::Action::step_back, view::Action::leap_back},
                        Row{view::Key::up, view::Action::varus_up, view::Action::varus_up},
                        Row{view::Key::down, view::Action::varus_down, view::Action::varus_down},
                        Row{view::key_of('+'), view::Action::faster, view::Action::faster},
                        Row{view::key_of('-'), view::Action::slower, view::Action::slower},
                        Row{view::key_of('L'), view::Action::next_loop, view::Action::next_loop},
                        Row{view::key_of('S'), view::Action::next_set, view::Action::previous_set},
                        Row{view::key_of('M'), view::Action::next_mode, view::Action::next_mode},
                        Row{view::key_of('1'), view::Action::view_front, view::Action::view_front},
                        Row{view::key_of('6'), view::Action::view_oblique, view::Action::view_oblique},
                        Row{view::key_of('R'), view::Action::reset_view, view::Action::reset_view},
                        Row{view::Key::f6, view::Action::show_ligaments, view::Action::show_ligaments},
                        Row{view::key_of('P'), view::Action::screenshot, view::Action::screenshot},
                        Row{view::key_of('F'), view::Action::full_screen, view::Action::full_screen},
                        Row{view::key_of('H'), view::Action::show_help, view::Action::show_help},
                        Row{view::Key::escape, view::Action::leave, view::Action::leave},
                        Row{view::key_of('Q'), view::Action::quit, view::Action::quit},
                        Row{view::key_of('Z'), view::Action::none, view::Action::none}}) {
    SCOPED_TRACE(static_cast<int>(row.key));
    EXPECT_EQ(view::action_of({row.key, false, false}), row.plain);
    EXPECT_EQ(view::action_of({row.key, true, false}), row.with_shift);
    EXPECT_EQ(view::action_of({row.key, false, true}), view::Action::none);
  }
}

TEST(Keys, EveryActionHasAKey)
{
  std::set<view::Action> reached;
  for (int key = 0; key <= static_cast<int>(view::Key::f8); ++key) {
    for (const bool has_shift : {false, true})
      reached.insert(view::action_of({static_cast<view::Key>(key), has_shift, false}));
  }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(view::Action::quit) + 1);
}

TEST(Keys, StepsGoOnWhileHeldAndSwitchesDoNot)
{
  for (const view::Key key : {view::Key::right, view::Key::left, view::Key::up, view::Key::down,
                              view::Key::page_up, view::Key::page_down})
    EXPECT_TRUE(view::repeats_while_held(view::action_of({key}))) << static_cast<int>(key);
  for (const view::Key key : {view::Key::space, view::key_of('S'), view::key_of('P'), view::key_of('F'),
                              view::Key::f1, view::Key::escape})
    EXPECT_FALSE(view::repeats_while_held(view::action_of({key}))) << static_cast<int>(key);
}

TEST(Keys, TheHelpIsWhole)
{
  const std::string text = view::help_text();
  for (const char* part : {"Space", "play or pause", "F1 ... F4", "screenshot", "Middle drag", "Q or Esc"})
    EXPECT_THAT(text, testing::HasSubstr(part));
  EXPECT_EQ(view::key_help().size(), 20u);
  EXPECT_EQ(view::mouse_help().size(), 5u);
}

}  // namespace vrda::keys_test
