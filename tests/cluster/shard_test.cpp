#include "cluster/shard.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/input_error.hpp"
#include "support/scratch.hpp"

namespace vrda::shard_test {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Shard, IsReadFromWords)
{
  EXPECT_EQ(shard_of("3/8"), (Shard{3, 8}));
  EXPECT_EQ(shard_of("1/1"), (Shard{1, 1}));
  for (const std::string text :
       {"", "3", "0/8", "9/8", "3/0", "-1/8", "3/8/2", "3 / 8", "a/b", "03/8", "/8", "3/", "3/99999999999"}) {
    const InputError::Facts facts = test::input_error([&] { shard_of(text); });
    EXPECT_EQ(facts.file, "--shard");
    EXPECT_EQ(facts.found, text.empty() ? "nothing" : text);
  }
}

TEST(Shard, RowsAreDealtOutInTurn)
{
  EXPECT_THAT(rows_of({1, 3}, 7), ElementsAre(0, 3, 6));
  EXPECT_THAT(rows_of({2, 3}, 7), ElementsAre(1, 4));
  EXPECT_THAT(rows_of({3, 3}, 7), ElementsAre(2, 5));
  EXPECT_THAT(rows_of({8, 8}, 7), IsEmpty());
}

TEST(Shard, EachRowBelongsToOneShardAndSharesDifferByOneAtMost)
{
  for (std::int32_t n_rows = 1; n_rows < 40; ++n_rows) {
    for (std::int32_t count = 1; count < 45; ++count) {
      std::vector<int> n_owners(static_cast<std::size_t>(n_rows), 0);
      for (std::int32_t number = 1; number <= count; ++number) {
        const auto rows = rows_of({number, count}, n_rows);
        EXPECT_GE(static_cast<std::int32_t>(rows.size()), n_rows / count);
        EXPECT_LE(static_cast<std::int32_t>(rows.size()), (n_rows + count - 1) / count);
        for (const std::int32_t row : rows) ++n_owners.at(static_cast<std::size_t>(row));
      }
      EXPECT_THAT(n_owners, testing::Each(1));
    }
  }
}

TEST(Shard, NamesOfJournalsLeadBackToTheirRun)
{
  const std::string output = "a.shard-1-of-2.journal/knee.h5";
  EXPECT_EQ(shard_journal_of(output, {12, 345}), output + ".shard-12-of-345.journal");
  EXPECT_EQ(output_of_journal(shard_journal_of(output, {12, 345})), output);
  EXPECT_EQ(shard_of_journal(shard_journal_of(output, {12, 345})), (Shard{12, 345}));
  EXPECT_EQ(output_of_journal(spine_journal_of(output)), output);
  EXPECT_EQ(shard_of_journal(spine_journal_of(output)), std::nullopt);
  for (const std::string other : {"knee.h5.journal", "knee.h5.shard-3-of-2.journal",
                                  "knee.h5.shard-x-of-2.journal", "knee.h5.shard-1-of-2", "knee.h5"}) {
    EXPECT_EQ(output_of_journal(other), "") << other;
    EXPECT_EQ(shard_of_journal(other), std::nullopt) << other;
  }
}

TEST(Shard, JournalsBesideAnOutputAreFoundInOrder)
{
  const test::Scratch scratch;
  const std::string output = scratch.path() / "knee.h5";
  for (const std::string name : {"knee.h5.shard-10-of-12.journal", "knee.h5.shard-2-of-12.journal",
                                 "knee.h5.shard-1-of-3.journal", "knee.h5.spine.journal", "knee.h5.journal",
                                 "other.h5.shard-1-of-3.journal", "knee.h5.shard-1-of-3.journal.partial"}) {
    scratch.write(name, "");
  }
  EXPECT_THAT(shard_journals_beside(output),
              ElementsAre(output + ".shard-1-of-3.journal", output + ".shard-2-of-12.journal",
                          output + ".shard-10-of-12.journal"));
  EXPECT_EQ(test::input_error([&] { shard_journals_beside(scratch.path() / "none" / "knee.h5"); }).file,
            scratch.path() / "none");
}

}  // namespace vrda::shard_test
