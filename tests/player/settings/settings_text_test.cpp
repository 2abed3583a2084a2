#include "settings/settings_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "documents/document.hpp"

namespace vrda::settings_text_test {

constexpr double largest = std::numeric_limits<double>::max();

documents::DocumentValue value_in(const std::string& text)
{
  return documents::value_at(documents::parse_toml("v = " + text, "a"), "v");
}

TEST(SettingsText, NumbersReadBackAsTheSameDouble)
{
  std::mt19937_64 random(81);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-1074, 1023);
  std::vector<double> values{0.0, -0.0, 1.0, -3.0, 1e22, 1e300, 5e-324, 0.1, 1.0 / 3.0, largest, -largest};
  while (values.size() < 500) values.push_back(std::ldexp(mantissa(random), exponent(random)));
  for (const double value : values) {
    EXPECT_EQ(documents::number_at(value_in(settings::number_text(value)), ""), value)
        << settings::number_text(value);
  }
  EXPECT_EQ(documents::numbers_of(value_in(settings::list_text(values))), values);
}

TEST(SettingsText, IsShortAndAlwaysANumberWithAPoint)
{
  EXPECT_EQ(settings::number_text(2.0), "2.0");
  EXPECT_EQ(settings::number_text(-0.5), "-0.5");
  EXPECT_EQ(settings::list_text(std::vector<double>{1.5, 2.0}), "[1.5, 2.0]");
  EXPECT_EQ(settings::list_text({}), "[]");
}

TEST(SettingsText, QuotedWordsReadBack)
{
  for (const std::string text : {"plain", "with \"quotes\" in it", "C:\\bench\\new",
                                 "knie gr\xc3\xbc\xc3\x9f", "# no comment", "'single'", "\\u0041", "]["}) {
    EXPECT_EQ(documents::text_at(value_in(vrda::settings::quoted_text(text)), ""), text);
  }
  // Escaped control characters are valid TOML, but rejected as settings.
  EXPECT_EQ(vrda::settings::quoted_text("a\nb\x7f"), "\"a\\u000Ab\\u007F\"");
}

}  // namespace vrda::settings_text_test
