#include "show/session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/document.hpp"

namespace vrda::show::settings_text_test {

constexpr double largest = std::numeric_limits<double>::max();

core::DocumentValue value_in(const std::string& text)
{
  return core::value_at(core::parse_toml("v = " + text, "a"), "v");
}

TEST(SettingsText, Numbers)
{
  std::mt19937_64 random(81);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-1074, 1023);
  std::vector<double> values{0.0, -0.0, 1.0, -3.0, 1e22, 1e300, 5e-324, 0.1, 1.0 / 3.0, largest, -largest};
  while (values.size() < 500) values.push_back(std::ldexp(mantissa(random), exponent(random)));
  for (const double value : values) {
    EXPECT_EQ(core::number_at(value_in(number_text(value)), ""), value) << number_text(value);
  }
  EXPECT_EQ(core::numbers_of(value_in(list_text(values))), values);
}

TEST(SettingsText, QuotedWordsReadBack)
{
  for (const std::string text : {"plain", "with \"quotes\" in it", "C:\\bench\\new",
                                 "knie gr\xc3\xbc\xc3\x9f", "# no comment", "'single'", "\\u0041", "]["}) {
    EXPECT_EQ(core::text_at(value_in(core::quoted_text(text)), ""), text);
  }
  // Escaped control characters are valid TOML, but rejected as settings.
  EXPECT_EQ(core::quoted_text("a\nb\x7f"), "\"a\\u000Ab\\u007F\"");
}

}  // namespace vrda::show::settings_text_test
