// Keys, gamepad and values of options.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <set>

#include "view/camera.hpp"
#include "view/keys.hpp"

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

using testing::ElementsAre;

TEST(Arguments, Angles)
{
  EXPECT_THAT(angles_deg(parsed_angles("--flexion", "0:90:30")), ElementsAre(0, 30, 60, 90));
  EXPECT_THAT(angles_deg(parsed_angles("--flexion", "-5:7:5")), ElementsAre(-5, 0, 5));
  EXPECT_THAT(angles_deg(parsed_angles("--flexion", "12.5")), ElementsAre(12.5));
  EXPECT_THAT(angles_deg(parsed_angles("--flexion", "3:3:1")), ElementsAre(3));
  // Ten steps of 0.1 reach the last angle in spite of rounding.
  EXPECT_EQ(angles_deg(parsed_angles("--flexion", "0:1:0.1")).size(), 11U);
  EXPECT_EQ(angles_deg(parsed_angles("--flexion", "0:1:0.1")).back(), 1.0);
}

TEST(Arguments, SizesAndViewsAreRead)
{
  EXPECT_EQ(parsed_size("640x480").width, 640);
  EXPECT_EQ(parsed_size("16x4096").height, 4096);
  EXPECT_THAT(parsed_views("front,oblique"), ElementsAre("front", "oblique"));
  EXPECT_EQ(view_named("side"), View::lateral);
}

TEST(Arguments, Labels)
{
  EXPECT_EQ(angle_label(5, {}), "005");
  EXPECT_EQ(angle_label(90, {0, 45}), "090");
  EXPECT_EQ(angle_label(7.5, {}), "007.5");
  EXPECT_EQ(angle_label(0, {7.5}), "000.0");
  EXPECT_EQ(angle_label(-0.0, {}), "000");
  EXPECT_EQ(angle_label(-5, {}), "-05");
  EXPECT_EQ(angle_label(1.0 / 3.0, {}), "000.333");
  EXPECT_EQ(angle_label(15.000000000000002, {}),
            "015");  // rounding of a conversion to radians and back
  EXPECT_LT(angle_label(9, {10}), angle_label(10, {9}));
}

std::size_t count_of(const std::vector<KeyPress>& keys, Key key)
{
  return static_cast<std::size_t>(std::ranges::count(keys, key, &KeyPress::key));
}

/// Number of presses of `key` in `seconds` at 60 rounds a second.
double presses(const Gamepad& pad, Key key, double seconds, bool is_plane = true)
{
  GamepadKeys keys;
  std::size_t n = 0;
  for (int k = 0; k < static_cast<int>(60.0 * seconds); ++k)
    n += count_of(keys.keys(pad, 1.0 / 60.0, is_plane), key);
  return static_cast<double>(n);
}

TEST(Gamepad, PadRepeats)
{
  Gamepad pad;
  pad.has_right = true;
  EXPECT_EQ(presses(pad, Key::right, 0.3), 1.0);
  // At 0.4 s and every 0.05 s from there, seen at the rounds up to 0.983 s after the press.
  EXPECT_EQ(presses(pad, Key::right, 1.0), 1.0 + 12.0);
  pad.has_a = true;
  EXPECT_EQ(presses(pad, Key::enter, 2.0), 1.0) << "a confirmation does not repeat";
}

TEST(Gamepad, Shoulders)
{
  Gamepad pad;
  pad.has_up = pad.has_b = pad.has_left_shoulder = pad.has_right_shoulder = true;
  GamepadKeys keys;
  const std::vector<KeyPress> first = keys.keys(pad, 0.0, true);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].key, Key::up);
  EXPECT_TRUE(first[0].has_shift && first[0].has_control);
  EXPECT_EQ(first[1].key, Key::backspace);
  EXPECT_FALSE(first[1].has_shift || first[1].has_control);
}

TEST(Gamepad, StickRate)
{
  Gamepad pad;
  pad.stick_x = -0.1;
  EXPECT_EQ(presses(pad, Key::left, 10.0), 0.0) << "at rest";
  pad.stick_x = -1.0;
  EXPECT_NEAR(presses(pad, Key::left, 10.0), 600.0, 1.0);
  // Halfway beyond the dead zone: an eighth.
  pad.stick_x = -0.575;
  EXPECT_NEAR(presses(pad, Key::left, 10.0), 75.0, 1.0);
  EXPECT_EQ(presses(pad, Key::right, 10.0), 0.0);
  pad.stick_y = 1.0;
  EXPECT_NEAR(presses(pad, Key::down, 10.0), 600.0, 1.0);
  EXPECT_EQ(presses(pad, Key::down, 10.0, false), 0.0) << "Up and Down would select";
}

}  // namespace vrda::view::keys_test
