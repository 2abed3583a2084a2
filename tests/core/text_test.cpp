#include "core/text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace vrda::text_test {

TEST(Utf8, TakesEveryCharacter)
{
  for (const std::string text :
       {"", "knee", "genou \xC3\xA9tal\xC3\xB3n", "\xE8\x86\x9D", "\xF0\x9F\xA6\xB5", "\x7F\xC2\x80",
        "\xDF\xBF\xE0\xA0\x80", "\xEF\xBF\xBF\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF", "\xED\x9F\xBF"}) {
    EXPECT_TRUE(is_utf8(text)) << text;
  }
}

TEST(Utf8, RefusesAllElse)
{
  struct Row {
    const char* why;
    std::string bytes;
  };
  for (const Row& row :
       {Row{"alone", "\x80"}, Row{"latin-1", "\xE9tal"}, Row{"cut", "ab\xC3"}, Row{"cut", "\xF0\x9F\xA6"},
        Row{"overlong", "\xC0\x80"}, Row{"overlong", "\xE0\x9F\xBF"}, Row{"overlong", "\xF0\x8F\xBF\xBF"},
        Row{"surrogate", "\xED\xA0\x80"}, Row{"too large", "\xF4\x90\x80\x80"}, Row{"no first byte", "\xF8"},
        Row{"no first byte", "\xFF"}}) {
    EXPECT_FALSE(is_utf8(row.bytes)) << row.why;
  }
}

TEST(Printable, control_characters)
{
  EXPECT_EQ(escape_control_characters("a\x1b[31m\n\x7f\xc2\x9b\xc2\xa0\xc3\xa9\xc2"),
            "a\\x1b[31m\\x0a\\x7f\\xc2\\x9b\xc2\xa0\xc3\xa9\xc2");
  EXPECT_TRUE(has_control_characters("a\xc2\x9b"));
  EXPECT_TRUE(has_control_characters("a\tb"));
  EXPECT_FALSE(has_control_characters("a\tb\n", "\t\n"));
  EXPECT_FALSE(has_control_characters("genou \xC3\xA9tal\xC3\xB3n"));
}

TEST(NumberText, fewest_digits)
{
  EXPECT_EQ(shortest_decimal(0.1), "0.1");
  EXPECT_EQ(shortest_decimal(-0.0), "0");
  EXPECT_EQ(shortest_decimal(5.0), "5");
  EXPECT_EQ(shortest_decimal(0.1 + 0.2), "0.30000000000000004");
}

TEST(EditDistance, edits)
{
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("vraus", "varus"), 2U);
  EXPECT_EQ(edit_distance("flexon", "flexion"), 1U);
  EXPECT_EQ(edit_distance("same", "same"), 0U);
  EXPECT_EQ(nearest_word("tibai", {"femur", "tibia"}), "tibia");
  EXPECT_EQ(nearest_word("x", {}), "");
}

// As printf prints them, with every digit of a large number.
TEST(NumberText, DigitsAndDecimals)
{
  EXPECT_EQ(rounded_text(0.14549), "0.14549");
  EXPECT_EQ(rounded_text(-1234.5678, 3), "-1.23e+03");
  EXPECT_EQ(rounded_text(nan), "nan");
  EXPECT_EQ(fixed_text(12.345, 1), "12.3");
  EXPECT_EQ(fixed_text(1e30, 0), "1000000000000000019884624838656");
}

}  // namespace vrda::text_test
