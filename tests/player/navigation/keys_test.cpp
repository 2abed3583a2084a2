#include "navigation/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace vrda::keys_test {

TEST(Keys, DoWhatTheIssueSays)
{
  struct Row {
    navigation::Key key;
    navigation::Action plain, with_shift;
  };
  for (const Row row :
       {Row{navigation::Key::space, navigation::Action::play_pause, navigation::Action::play_pause},
        Row{navigation::Key::right, navigation::Action::step_forward, navigation::Action::leap_forward},
        Row{navigation::Key::left, navigation::Action::step_back, navigation::Action::leap_back},
        Row{navigation::Key::up, navigation::Action::varus_up, navigation::Action::varus_up},
        Row{navigation::Key::down, navigation::Action::varus_down, navigation::Action::varus_down},
        Row{navigation::key_of('+'), navigation::Action::faster, navigation::Action::faster},
        Row{navigation::key_of('-'), navigation::Action::slower, navigation::Action::slower},
        Row{navigation::key_of('L'), navigation::Action::next_loop, navigation::Action::next_loop},
        Row{navigation::key_of('S'), navigation::Action::next_set, navigation::Action::previous_set},
        Row{navigation::key_of('M'), navigation::Action::next_mode, navigation::Action::next_mode},
        Row{navigation::key_of('1'), navigation::Action::view_front, navigation::Action::view_front},
        Row{navigation::key_of('6'), navigation::Action::view_oblique, navigation::Action::view_oblique},
        Row{navigation::key_of('R'), navigation::Action::reset_view, navigation::Action::reset_view},
        Row{navigation::Key::f6, navigation::Action::show_ligaments, navigation::Action::show_ligaments},
        Row{navigation::key_of('P'), navigation::Action::screenshot, navigation::Action::screenshot},
        Row{navigation::key_of('F'), navigation::Action::full_screen, navigation::Action::full_screen},
        Row{navigation::key_of('H'), navigation::Action::show_help, navigation::Action::show_help},
        Row{navigation::Key::escape, navigation::Action::leave, navigation::Action::leave},
        Row{navigation::key_of('Q'), navigation::Action::quit, navigation::Action::quit},
        Row{navigation::key_of('Z'), navigation::Action::none, navigation::Action::none}}) {
    SCOPED_TRACE(static_cast<int>(row.key));
    EXPECT_EQ(navigation::action_of({row.key, false, false}), row.plain);
    EXPECT_EQ(navigation::action_of({row.key, true, false}), row.with_shift);
    EXPECT_EQ(navigation::action_of({row.key, false, true}), navigation::Action::none);
  }
}

TEST(Keys, EveryActionHasAKey)
{
  std::set<navigation::Action> reached;
  for (int key = 0; key <= static_cast<int>(navigation::Key::f8); ++key) {
    for (const bool has_shift : {false, true})
      reached.insert(navigation::action_of({static_cast<navigation::Key>(key), has_shift, false}));
  }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(navigation::Action::quit) + 1);
}

TEST(Keys, StepsGoOnWhileHeldAndSwitchesDoNot)
{
  for (const navigation::Key key :
       {navigation::Key::right, navigation::Key::left, navigation::Key::up, navigation::Key::down,
        navigation::Key::page_up, navigation::Key::page_down})
    EXPECT_TRUE(navigation::repeats_while_held(navigation::action_of({key}))) << static_cast<int>(key);
  for (const navigation::Key key : {navigation::Key::space, navigation::key_of('S'), navigation::key_of('P'),
                                    navigation::key_of('F'), navigation::Key::f1, navigation::Key::escape})
    EXPECT_FALSE(navigation::repeats_while_held(navigation::action_of({key}))) << static_cast<int>(key);
}

TEST(Keys, TheHelpIsWhole)
{
  const std::string text = navigation::help_text();
  for (const char* part : {"Space", "play or pause", "F1 ... F4", "screenshot", "Middle drag", "Q or Esc"})
    EXPECT_THAT(text, testing::HasSubstr(part));
  EXPECT_EQ(navigation::key_help().size(), 20u);
  EXPECT_EQ(navigation::mouse_help().size(), 5u);
}

}  // namespace vrda::keys_test
