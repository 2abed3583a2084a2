#include "core/nearest_word.hpp"

#include <gtest/gtest.h>

namespace vrda::nearest_word_test {

TEST(EditDistance, CountsInsertionsDeletionsAndReplacements)
{
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("vraus", "varus"), 2U);
  EXPECT_EQ(edit_distance("flexon", "flexion"), 1U);
  EXPECT_EQ(edit_distance("same", "same"), 0U);
  EXPECT_EQ(nearest_word("tibai", {"femur", "tibia"}), "tibia");
  EXPECT_EQ(nearest_word("x", {}), "");
}

TEST(Alternatives, AreAList)
{
  EXPECT_EQ(alternatives({}), "");
  EXPECT_EQ(alternatives({"a"}), "a");
  EXPECT_EQ(alternatives({"a", "b"}), "a or b");
  EXPECT_EQ(alternatives({"a", "b", "c"}), "a, b or c");
}

}  // namespace vrda::nearest_word_test
