#include "support/refusal.hpp"

#include <gtest/gtest.h>

namespace vrda::refusal_test {

using test::refuses;
using testing::Not;

const InputError::Facts facts{"/jobs/a.toml", "grid.varus", "-3 of \"x y\"", "at most 1.5", 7};

TEST(Refusal, IsComparedByItsValues)
{
  EXPECT_THAT(facts, refuses({.field = "grid.varus"}));
  for (const test::Refusal& same : {test::Refusal{"/jobs/a.toml", "line 7, grid.varus", "-3", "1.5"},
                                    {"a.toml", "grid.varus", {"\"x y\"", "-3"}}})
    EXPECT_THAT(facts, refuses(same));
  for (const test::Refusal& other : {test::Refusal{"b.toml", "grid.varus"},
                                     {".toml", "grid.varus"},
                                     {"", "grid"},
                                     {"", "varus"},
                                     {"", ""},
                                     {"", "line 8, grid.varus"},
                                     {"", "grid.varus", "3"},
                                     {"", "grid.varus", {"-3", "2"}},
                                     {"", "grid.varus", "-33"},
                                     {"", "grid.varus", "z"},
                                     {"", "grid.varus", "", "1"},
                                     {"", "grid.varus", "", "5"},
                                     {"", "grid.varus", "", "mos"}})
    EXPECT_THAT(facts, Not(refuses(other))) << other.field;
}

TEST(Refusal, OfAProgramIsReadFromItsLastLine)
{
  test::Ended ended{2, "",
                    std::string("warning: a: found b, wanted c\nvrda: ") + InputError(facts).what() + "\n"};
  EXPECT_THAT(ended, refuses({"a.toml", "grid.varus", "-3", "1.5"}));
  EXPECT_THAT(ended, refuses({"/jobs/a.toml", "line 7, grid.varus"}));
  EXPECT_THAT(ended, Not(refuses({.file = "a.toml"})));
  EXPECT_THAT(ended, Not(refuses({"a.toml", "grid.varus", "1.5"})));
  EXPECT_THAT(ended, Not(refuses({"a.toml", "grid.varus", "-3", "3"})));
  EXPECT_THAT(ended, Not(refuses({.field = "grid.varus", .exit_code = 5})));
  ended.exit_code = 0;
  EXPECT_THAT(ended, Not(refuses({.field = "grid.varus"})));
  ended = {2, "", "vrda: --shard: found \"3\" (see vrda run --help)\n"};
  EXPECT_THAT(ended, refuses({.file = "--shard", .found = "\"3\""}));
  EXPECT_THAT((test::Ended{2, "", ""}), Not(refuses({.found = "3"})));
}

}  // namespace vrda::refusal_test
