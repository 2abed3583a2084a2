#include "core/text.hpp"

#include <gtest/gtest.h>

namespace vrda::error_test {

TEST(InputError, message)
{
  EXPECT_STREQ(InputError({"a.toml", "grid.varus", "0", "a step"}).what(),
               "a.toml: grid.varus: found 0, wanted a step");
  EXPECT_STREQ(InputError({"a.toml", "grid.varus", "0", "a step", 7}).what(),
               "a.toml: line 7, grid.varus: found 0, wanted a step");
  EXPECT_STREQ(InputError({"a.toml", "", "0", "a step", 7}).what(), "a.toml: line 7: found 0, wanted a step");
  EXPECT_STREQ(InputError({"a.stl", "", "nothing", ""}).what(), "a.stl: found nothing");
  EXPECT_STREQ(InputError({"", "", "nothing", "room"}).what(), "found nothing, wanted room");
}

TEST(InputError, any_bytes)
{
  const std::string bytes("a\n\r\t\x1b[31m\0\x7f\xc3\xa9", 13);
  EXPECT_EQ(std::string(InputError({"f", "", bytes, ""}).what()),
            "f: found a\\x0a\\x0d\\x09\\x1b[31m\\x00\\x7f\xc3\xa9");
  EXPECT_EQ(InputError({"f", "", bytes, ""}).facts().found, bytes);
}

TEST(InputError, long_fact)
{
  const std::string text = InputError({"f", std::string(1'000'000, 'k'), "b", "c"}).what();
  EXPECT_LT(text.size(), 6000u);
  EXPECT_NE(text.find("k...: found b, wanted c"), std::string::npos);
}

}  // namespace vrda::error_test
