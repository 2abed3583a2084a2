#include "view/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/refusal.hpp"

namespace vrda::arguments_test {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Arguments, AnglesRunFromTheFirstToTheLast)
{
  EXPECT_THAT(view::angles_deg(view::parsed_angles("--flexion", "0:90:30")), ElementsAre(0, 30, 60, 90));
  EXPECT_THAT(view::angles_deg(view::parsed_angles("--flexion", "-5:7:5")), ElementsAre(-5, 0, 5));
  EXPECT_THAT(view::angles_deg(view::parsed_angles("--flexion", "12.5")), ElementsAre(12.5));
  EXPECT_THAT(view::angles_deg(view::parsed_angles("--flexion", "3:3:1")), ElementsAre(3));
  // Ten steps of 0.1 reach the last angle in spite of rounding.
  EXPECT_EQ(view::angles_deg(view::parsed_angles("--flexion", "0:1:0.1")).size(), 11U);
  EXPECT_EQ(view::angles_deg(view::parsed_angles("--flexion", "0:1:0.1")).back(), 1.0);
}

TEST(Arguments, WrongAnglesAreNamed)
{
  for (const std::string text :
       {"", "a", "0:90", "0:90:15:1", "0:90:", "0:nan:1", "inf", "0 :90:1", "0:4e2:1"}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(test::input_error([&] { view::parsed_angles("--flexion", text); }),
                test::refuses({"--flexion", "", "\"" + text + "\"", "A:B:STEP"}));
  }
}

TEST(Arguments, ReversedEndlessAndHugeSeriesAreNamed)
{
  struct Row {
    std::string text, found, wanted;
  };
  for (const Row& row : {Row{"90:0:15", "\"90:0:15\"", "A at most B"}, Row{"0:90:0", "0", "0.001 or more"},
                         Row{"0:90:-5", "-5", "0.001 or more"}, Row{"0:1:0.0009", "0.0009", "0.001 or more"},
                         Row{"0:90:0.001", "0.001", "at most 10000 angles"}}) {
    SCOPED_TRACE(row.text);
    const InputError::Facts facts = test::input_error([&] { view::parsed_angles("--flexion", row.text); });
    EXPECT_EQ(facts.found, row.found);
    EXPECT_THAT(facts.wanted, HasSubstr(row.wanted));
  }
}

TEST(Arguments, AnAngleIsANumberWithinATurn)
{
  for (const double angle_deg : {-360.0, 0.0, 12.5, 360.0})
    EXPECT_NO_THROW(view::require_angle("--varus", angle_deg));
  for (const double angle_deg : {std::nan(""), 361.0, -1e300, HUGE_VAL})
    EXPECT_THROW(view::require_angle("--varus", angle_deg), InputError) << angle_deg;
}

TEST(Arguments, SizesAreTwoNumbersWithinBounds)
{
  EXPECT_EQ(view::parsed_size("640x480").width, 640);
  EXPECT_EQ(view::parsed_size("16x4096").height, 4096);
  for (const std::string text : {"", "640", "640x", "x480", "640x480x2", "640X480", "15x480", "640x4097",
                                 "-640x480", "6.4x480", "99999999999x480"}) {
    SCOPED_TRACE(text);
    EXPECT_THAT(test::input_error([&] { view::parsed_size(text); }),
                test::refuses({"--size", "", "\"" + text + "\"", "WxH"}));
  }
}

TEST(Arguments, ViewsAreKnownNamesOnce)
{
  EXPECT_THAT(view::parsed_views("front,oblique"), ElementsAre("front", "oblique"));
  struct Row {
    std::string text, found, wanted;
  };
  for (const Row& row : {Row{"front,below", "\"below\"", "front, back, left"}, Row{"", "\"\"", "front, back"},
                         Row{"front,", "\"\"", "front, back"}, Row{"top,top", "top twice", "once"}}) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::input_error([&] { view::parsed_views(row.text); }),
                test::refuses({"--views", "", row.found, row.wanted}));
  }
}

TEST(Arguments, LabelsSortLikeTheirAngles)
{
  EXPECT_EQ(view::angle_label(5, {}), "005");
  EXPECT_EQ(view::angle_label(90, {0, 45}), "090");
  EXPECT_EQ(view::angle_label(7.5, {}), "007.5");
  EXPECT_EQ(view::angle_label(0, {7.5}), "000.0");
  EXPECT_EQ(view::angle_label(-0.0, {}), "000");
  EXPECT_EQ(view::angle_label(-5, {}), "-05");
  EXPECT_EQ(view::angle_label(1.0 / 3.0, {}), "000.333");
  EXPECT_EQ(view::angle_label(15.000000000000002, {}),
            "015");  // rounding of a conversion to radians and back
  EXPECT_LT(view::angle_label(9, {10}), view::angle_label(10, {9}));
}

}  // namespace vrda::arguments_test
