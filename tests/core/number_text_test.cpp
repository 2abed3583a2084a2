#include "core/number_text.hpp"

#include <gtest/gtest.h>

namespace vrda::number_text_test {

TEST(NumberText, NumbersAreWrittenInTheFewestDigits)
{
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(-0.0), "0");
  EXPECT_EQ(shortest(5.0), "5");
  EXPECT_EQ(shortest(0.1 + 0.2), "0.30000000000000004");
}

}  // namespace vrda::number_text_test
