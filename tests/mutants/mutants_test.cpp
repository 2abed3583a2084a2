// The program reads motion models, traces and journals with changed content and valid checksums.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "app/scenes.hpp"
#include "fuzz/changed_content.hpp"
#include "fuzz/framed_checksums.hpp"
#include "run/submission.hpp"
#include "store/read_separately.hpp"
#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::mutants_test {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::HasSubstr;

// Limits of this test's requirement. Under sanitizers the process that reads has no limit of memory.
constexpr long most_kb = store::is_sanitized ? std::numeric_limits<long>::max() : 600L * 1024;
constexpr double most_processor_s = 10.0;

int n_mutants()
{
  const char* requested = std::getenv("VRDA_MUTANTS");
  return requested != nullptr ? std::atoi(requested) : 200;
}

/// One to three changes, with repaired checksums.
std::vector<std::uint8_t> recipe(std::mt19937_64& random)
{
  std::vector<std::uint8_t> bytes(2 + 8 * (1 + random() % 3));
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  // Changes of bytes or through HDF5; changed_content.cpp leaves checksums and seal invalid for 1 and 2.
  while (bytes[1] % 8 == 1 || bytes[1] % 16 == 2) ++bytes[1];
  return bytes;
}

void change_bytes(std::string& bytes, std::mt19937_64& random)
{
  for (std::size_t n = 1 + random() % 4; n > 0; --n)
    bytes[random() % bytes.size()] = static_cast<char>(random());
  std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
  test::repair_checksums(data.data(), data.size());
  bytes.assign(data.begin(), data.end());
}

class Mutants : public testing::Test {
 protected:
  /// Checks the exit: a result, or one error message that names `file`, within limits.
  void run_on(const std::string& file, const std::vector<std::string>& words)
  {
    const test::Ended ended = test::run_vrda(words);
    ++n_ended_[words.front() + (ended.exit_code == 0 ? ": accepted" : ": rejected")];
    EXPECT_THAT(ended.exit_code, AnyOf(0, 2, 3)) << ended.err;
    EXPECT_LE(ended.peak_kb, most_kb);
    EXPECT_LE(ended.processor_s, most_processor_s);
    if (ended.exit_code == 2) {
      EXPECT_THAT(ended.out + ended.err, HasSubstr(fs::path(file).filename().string()));
    }
  }

  void keep(const std::string& file, int k)
  {
    if (!HasFailure() || is_kept_) return;
    is_kept_ = true;
    const fs::path kept = fs::temp_directory_path() / ("vrda-mutant-" + std::to_string(k));
    fs::copy_file(file, kept, fs::copy_options::overwrite_existing);
    std::cout << "the first mutant that failed is " << kept.string() << '\n';
  }

  void TearDown() override
  {
    for (const auto& [what, n] : n_ended_) std::cout << "outcome: " << n << ' ' << what << '\n';
  }

  test::Scratch scratch_;
  std::map<std::string, int> n_ended_;
  bool is_kept_ = false;
};

TEST_F(Mutants, OfModelsAndTracesGiveAResultOrOneRefusal)
{
  const std::string file = (scratch_.path() / "knee.h5").string();
  const std::string table = (scratch_.path() / "table.csv").string();
  const std::array<std::vector<std::string>, 4> commands{{
      {"info", file},
      {"validate", file},
      {"smooth", file, "--degree", "2"},
      {"export", file, "--to", "csv", "-o", table},
  }};
  const int n = n_mutants() * 4 / 5;
  for (int k = 0; k < n; ++k) {
    SCOPED_TRACE(k);
    std::mt19937_64 random(static_cast<std::uint64_t>(k));
    const std::vector<std::uint8_t> changes = recipe(random);
    scratch_.write("knee.h5",
                   test::changed_file(changes.data(), changes.size(), static_cast<std::size_t>(k)).bytes);
    run_on(file, commands[static_cast<std::size_t>(k) % commands.size()]);
    keep(file, k);
    fs::remove(table);
  }
  // Neither all rejected before HDF5 parses them, nor all accepted.
  for (const char* outcome : {"info: accepted", "info: rejected", "validate: rejected", "export: accepted"})
    EXPECT_GT(n_ended_[outcome], 0) << outcome;
}

TEST_F(Mutants, OfJournalsGiveAResultOrOneRefusal)
{
  const fs::path job = test::small_job(scratch_);
  const std::string output = (scratch_.path() / "merged.h5").string();
  const std::string spine = store::spine_journal_of(output), shard = store::shard_journal_of(output, {1, 1});
  ASSERT_EQ(test::run_vrda({"run", job.string(), "-o", output, "--spine"}).exit_code, 0);
  ASSERT_EQ(test::run_vrda({"run", job.string(), "-o", output, "--shard", "1/1"}).exit_code, 0);
  const std::string file = (scratch_.path() / "changed.journal").string();
  // A journal without some steps is reported with the model that needs them.
  const std::string model = (scratch_.path() / "changed.journal.h5").string();
  for (int k = 0; k < n_mutants() / 5; ++k) {
    SCOPED_TRACE(k);
    std::mt19937_64 random(static_cast<std::uint64_t>(k));
    std::string changed = test::read_bytes(k % 2 == 0 ? spine : shard);
    change_bytes(changed, random);
    scratch_.write("changed.journal", changed);
    run_on(file, {"merge", file, k % 2 == 0 ? shard : spine, "-o", model, "--job", job.string(), "--keep"});
    keep(file, k);
    fs::remove(model);
  }
  for (const char* outcome : {"merge: accepted", "merge: rejected"})
    EXPECT_GT(n_ended_[outcome], 0) << outcome;
}

}  // namespace vrda::mutants_test
