#include "view/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace vrda::keys_test {

TEST(Keys, DoWhatTheIssueSays)
{
  struct Row {
    Key key;
    Action plain, with_shift;
  };
  for (const Row row : {Row{Key::space, Action::play_pause, Action::play_pause},
                        Row{Key::right, Action::step_forward, Action::leap_forward},
                        Row{Key::left, Action::step_back, Action::leap_back},
                        Row{Key::up, Action::varus_up, Action::varus_up},
                        Row{Key::down, Action::varus_down, Action::varus_down},
                        Row{key_of('+'), Action::faster, Action::faster},
                        Row{key_of('-'), Action::slower, Action::slower},
                        Row{key_of('L'), Action::next_loop, Action::next_loop},
                        Row{key_of('S'), Action::next_set, Action::previous_set},
                        Row{key_of('M'), Action::next_mode, Action::next_mode},
                        Row{key_of('1'), Action::view_front, Action::view_front},
                        Row{key_of('6'), Action::view_oblique, Action::view_oblique},
                        Row{key_of('R'), Action::reset_view, Action::reset_view},
                        Row{Key::f6, Action::show_ligaments, Action::show_ligaments},
                        Row{key_of('P'), Action::screenshot, Action::screenshot},
                        Row{key_of('F'), Action::full_screen, Action::full_screen},
                        Row{key_of('H'), Action::show_help, Action::show_help},
                        Row{Key::escape, Action::leave, Action::leave},
                        Row{key_of('Q'), Action::quit, Action::quit},
                        Row{key_of('Z'), Action::none, Action::none}}) {
    SCOPED_TRACE(static_cast<int>(row.key));
    EXPECT_EQ(action_of({row.key, false, false}), row.plain);
    EXPECT_EQ(action_of({row.key, true, false}), row.with_shift);
    EXPECT_EQ(action_of({row.key, false, true}), Action::none);
  }
}

TEST(Keys, EveryActionHasAKey)
{
  std::set<Action> reached;
  for (int key = 0; key <= static_cast<int>(Key::f11); ++key) {
    for (const bool has_shift : {false, true})
      reached.insert(action_of({static_cast<Key>(key), has_shift, false}));
  }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(Action::quit) + 1);
}

TEST(Keys, StepsGoOnWhileHeldAndSwitchesDoNot)
{
  for (const Key key : {Key::right, Key::left, Key::up, Key::down, Key::page_up, Key::page_down})
    EXPECT_TRUE(goes_on_while_held(action_of({key}))) << static_cast<int>(key);
  for (const Key key : {Key::space, key_of('S'), key_of('P'), key_of('F'), Key::f1, Key::escape})
    EXPECT_FALSE(goes_on_while_held(action_of({key}))) << static_cast<int>(key);
}

TEST(Keys, TheHelpIsWhole)
{
  const std::string text = help_text();
  for (const char* part : {"Space", "play or pause", "F1 ... F6", "screenshot", "Middle drag", "Q or Esc"})
    EXPECT_THAT(text, testing::HasSubstr(part));
  EXPECT_EQ(key_help().size(), 19u);
  EXPECT_EQ(mouse_help().size(), 5u);
}

}  // namespace vrda::keys_test
