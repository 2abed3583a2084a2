// A journal that was cut or has a flipped bit: the records before the damage are kept, the rest is solved
// again.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

#include "app/scenes.hpp"
#include "core/framed_file.hpp"
#include "core/text.hpp"
#include "faults/faulty_run.hpp"
#include "store/journal.hpp"
#include "support/messages.hpp"

namespace vrda::test::journal_damage_test {

class JournalDamage : public FaultyRun {
 protected:
  JournalDamage()
  {
    // Killed before its last record: the journal contains all others.
    run_from_empty({"kill", "open", "1", "a.h5.partial"});
    bytes_ = read_bytes(journal());
    // Magic, version, length of the key, key, checksum; then of each frame its length, checksum and content.
    std::size_t end = 8 + 4 + 4 + core::u32_at(bytes_, 12) + 4;
    for (; end < bytes_.size(); end += 8 + core::u32_at(bytes_, end)) ends_.push_back(end);
    ends_.push_back(end);
    EXPECT_EQ(end, bytes_.size());
    EXPECT_GT(ends_.size(), 6u);
  }

  /// Number of complete frames that end at or before this byte.
  std::size_t n_whole_before(std::size_t byte) const
  {
    return static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), byte) - ends_.begin()) - 1;
  }

  std::string flipped(std::size_t byte, int bit) const
  {
    std::string damaged = bytes_;
    damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << bit));
    return damaged;
  }

  void put_journal(const std::string& bytes) const { std::ofstream(journal(), std::ios::binary) << bytes; }

  /// The first `n_kept` frames are recalled, the rest is solved again; the message reports the dropped bytes.
  void expect_goes_on(const std::string& damaged, std::size_t n_kept) const
  {
    std::filesystem::remove(folder_ / "a.h5");  // a finished job reads no journal
    put_journal(damaged);
    const std::string said = expect_finishes();
    EXPECT_EQ(n_steps_recalled(), static_cast<int>(n_kept));
    EXPECT_THAT(said, warns(journal(), std::to_string(damaged.size() - ends_[n_kept]) + " bytes"));
  }

  std::string bytes_;
  std::vector<std::size_t> ends_;  ///< of the header, then of each frame
};

void expect_content(const store::JournalContent& content, std::size_t n_records, std::size_t valid,
                    std::size_t size)
{
  EXPECT_EQ(content.records.size(), n_records);
  EXPECT_EQ(content.valid_bytes, valid);
  EXPECT_EQ(content.dropped_bytes, size - valid);
  EXPECT_EQ(content.dropped_reason.empty(), size == valid);
}

TEST_P(JournalDamage, EveryLengthIsReadUpToItsLastWholeRecord)
{
  for (std::size_t size = ends_[0]; size <= bytes_.size(); ++size) {
    SCOPED_TRACE(size);
    const std::size_t n = n_whole_before(size);
    expect_content(store::parse_journal("a", bytes_.substr(0, size)), n, ends_[n], size);
  }
}

TEST_P(JournalDamage, EveryFlippedBitIsDetected)
{
  for (std::size_t byte = ends_[0]; byte < bytes_.size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      SCOPED_TRACE(std::to_string(byte) + " " + std::to_string(bit));
      const std::size_t n = n_whole_before(byte);
      expect_content(store::parse_journal("a", flipped(byte, bit)), n, ends_[n], bytes_.size());
    }
  }
}

TEST_P(JournalDamage, EveryDamageToTheHeaderIsAnErrorThatNamesTheFile)
{
  int n_refused = 0;
  const auto count_refusal = [&](const std::string& damaged) {
    try {
      store::parse_journal("a.journal", damaged);
    } catch (const InputError& error) {
      n_refused += error.facts().file == "a.journal" ? 1 : 0;
    }
  };
  const int n_bytes = static_cast<int>(ends_[0]);
  for (std::size_t byte = 0; byte < ends_[0]; ++byte) {
    for (int bit = 0; bit < 8; ++bit) count_refusal(flipped(byte, bit));
    count_refusal(bytes_.substr(0, byte));
  }
  EXPECT_EQ(n_refused, 9 * n_bytes);
}

TEST_P(JournalDamage, ARunResumesBeforeTheDamage)
{
  // Offsets with a stride that is coprime to a record's length, and the ends of each record.
  const std::size_t n = ends_.size() - 1;
  for (const std::size_t size : {ends_[0] + 1, ends_[0] + 7, ends_[1] - 1, ends_[2] + 8, ends_[n] - 1}) {
    SCOPED_TRACE(size);
    expect_goes_on(bytes_.substr(0, size), n_whole_before(size));
  }
  for (std::size_t byte = ends_[0]; byte < bytes_.size(); byte += (bytes_.size() - ends_[0]) / 9) {
    SCOPED_TRACE(byte);
    expect_goes_on(flipped(byte, static_cast<int>(byte % 8)), n_whole_before(byte));
  }
}

TEST_P(JournalDamage, ADamagedHeaderIsReportedAndTheJournalKept)
{
  for (const std::string& damaged : {flipped(3, 0), flipped(8, 1), flipped(40, 5), flipped(ends_[0] - 1, 7),
                                     bytes_.substr(0, ends_[0] - 1), std::string()}) {
    put_journal(damaged);
    const Ended ended = run();
    expect_refused(ended);
    EXPECT_THAT(ended, refuses({journal(), "header"}));
    EXPECT_EQ(read_bytes(journal()), damaged);
  }
  Command fresh = command();
  fresh.arguments.emplace_back("--fresh");
  EXPECT_EQ(test::run(fresh).exit_code, 0);
  expect_finished();
}

INSTANTIATE_TEST_SUITE_P(All, JournalDamage, testing::Values(search(), equilibrium()), name_of);

}  // namespace vrda::test::journal_damage_test
