#include "view/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace vrda::view::keys_test {

TEST(Keys, EveryActionHasAKey)
{
  std::set<Action> reached;
  for (int key = 0; key <= static_cast<int>(Key::f8); ++key) {
    for (const bool has_shift : {false, true})
      reached.insert(action_of({static_cast<Key>(key), has_shift, false}));
  }
  EXPECT_EQ(reached.size(), static_cast<std::size_t>(Action::quit) + 1);
}

TEST(Keys, HeldKeys)
{
  for (const Key key : {Key::right, Key::left, Key::up, Key::down, Key::page_up, Key::page_down})
    EXPECT_TRUE(repeats_while_held(action_of({key}))) << static_cast<int>(key);
  for (const Key key : {Key::space, key_of('S'), key_of('P'), key_of('F'), Key::f1, Key::escape})
    EXPECT_FALSE(repeats_while_held(action_of({key}))) << static_cast<int>(key);
}

}  // namespace vrda::view::keys_test
