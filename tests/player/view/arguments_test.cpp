#include "view/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "support/refusal.hpp"
#include "view/camera.hpp"

namespace vrda::view::arguments_test {

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

TEST(Arguments, AngleLimits)
{
  for (const double angle_deg : {-360.0, 0.0, 12.5, 360.0})
    EXPECT_NO_THROW(require_angle("--varus", angle_deg));
  for (const double angle_deg : {std::nan(""), 361.0, -1e300, HUGE_VAL})
    EXPECT_THROW(require_angle("--varus", angle_deg), InputError) << angle_deg;
}

TEST(Arguments, SizesAndViewsAreRead)
{
  EXPECT_EQ(parsed_size("640x480").width, 640);
  EXPECT_EQ(parsed_size("16x4096").height, 4096);
  EXPECT_THAT(parsed_views("front,oblique"), ElementsAre("front", "oblique"));
  EXPECT_EQ(view_named("side"), View::lateral);
}

TEST(Arguments, OthersAreRefused)
{
  const auto angles = [](const std::string& text) { parsed_angles("--flexion", text); };
  const auto size = [](const std::string& text) { parsed_size(text); };
  const auto views = [](const std::string& text) { parsed_views(text); };
  struct Row {
    std::function<void(const std::string&)> parse;
    std::vector<const char*> texts;
    const char *option, *field, *wanted;
  };
  for (const Row& row :
       {Row{angles,
            {"", "a", "0:90", "0:90:15:1", "0:90:", "0:nan:1", "inf", "0 :90:1", "0:4e2:1"},
            "--flexion",
            "",
            "A:B:STEP"},
        Row{angles, {"90:0:15"}, "--flexion", "", "A at most B"},
        Row{angles, {"0:90:0", "0:90:-5", "0:1:0.0009"}, "--flexion", "STEP", "0.001 or more"},
        Row{angles, {"0:90:0.001"}, "--flexion", "STEP", "at most 10000 angles"},
        Row{size,
            {"", "640", "640x", "x480", "640x480x2", "640X480", "15x480", "640x4097", "-640x480", "6.4x480",
             "99999999999x480"},
            "--size",
            "",
            "WxH"},
        Row{views, {"front,below", "", "front,"}, "--views", "", "front, back, left"},
        Row{views, {"top,top"}, "--views", "", "once"}}) {
    for (const char* const text : row.texts) {
      SCOPED_TRACE(text);
      EXPECT_THAT(test::input_error([&] { row.parse(text); }),
                  test::refuses({row.option, row.field, "", row.wanted}));
    }
  }
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

}  // namespace vrda::view::arguments_test
