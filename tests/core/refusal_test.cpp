#include "support/messages.hpp"

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

TEST(Messages, AreComparedByTheirValues)
{
  const std::string said =
      "vrda: 15 attitudes\nwarning: push.force_n: found 50, no effect\n/a/knee.h5: 35 of 40 stable\n"
      "a.toml: line 8, grid.varus: 3; use vrda plan\n";
  for (const auto& same : {test::reports("", {"15", "attitudes"}), test::reports("push.force_n"),
                           test::warns("push.force_n", "50"), test::reports("knee.h5", {"40", "35"}),
                           test::reports("/a/knee.h5"), test::reports("grid.varus", "vrda plan"),
                           test::reports("a.toml", {"grid.varus", "3"}), test::warns("", "50")})
    EXPECT_THAT(said, same);
  for (const auto& other :
       {test::reports("", {"15", "stable"}), test::reports("force_n"), test::warns("push.force_n", "5"),
        test::warns("knee.h5"), test::reports("h5"), test::reports("knee.h5", "15"), test::warns("", "35")})
    EXPECT_THAT(said, Not(other));
}

}  // namespace vrda::refusal_test
