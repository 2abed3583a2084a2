#include "settings/settings_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "settings/settings_table.hpp"

namespace vrda::settings_text_test {

constexpr NumberRange all{-std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};

TEST(SettingsText, NumbersReadBackAsTheSameDouble)
{
  std::mt19937_64 random(81);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-1074, 1023);
  std::vector<double> values{0.0, -0.0, 1.0, -3.0, 1e22, 1e300, 5e-324, 0.1, 1.0 / 3.0, all.most, all.least};
  while (values.size() < 500) values.push_back(std::ldexp(mantissa(random), exponent(random)));
  for (const double value : values) {
    const SettingsTable table = SettingsTable::parsed("v = " + number_text(value), "a");
    EXPECT_EQ(table.number("v", all), value) << number_text(value);
  }
  const SettingsTable table = SettingsTable::parsed("v = " + list_text(values), "a");
  EXPECT_EQ(table.numbers("v", values.size(), all), values);
}

TEST(SettingsText, IsShortAndAlwaysANumberWithAPoint)
{
  EXPECT_EQ(number_text(2.0), "2.0");
  EXPECT_EQ(number_text(-0.5), "-0.5");
  EXPECT_EQ(list_text(std::vector<double>{1.5, 2.0}), "[1.5, 2.0]");
  EXPECT_EQ(list_text({}), "[]");
}

TEST(SettingsText, QuotedWordsReadBack)
{
  for (const std::string text : {"plain", "with \"quotes\" in it", "C:\\bench\\new",
                                 "knie gr\xc3\xbc\xc3\x9f", "# no comment", "'single'", "\\u0041", "]["}) {
    EXPECT_EQ(SettingsTable::parsed("v = " + vrda::quoted_text(text), "a").text("v"), text);
    EXPECT_EQ(SettingsTable::parsed("v = [" + vrda::quoted_text(text) + "]", "a").texts("v"),
              std::vector<std::string>{text});
  }
  // Control characters are valid TOML so, and refused as settings.
  EXPECT_EQ(vrda::quoted_text("a\nb\x7f"), "\"a\\u000Ab\\u007F\"");
}

}  // namespace vrda::settings_text_test
