// `vrda rom`: files of a coarse range of the generic hip, comparison.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "support/messages.hpp"

namespace vrda::rom_command_test {

using nlohmann::json;

class RomCommand : public test::CommandTest {
 protected:
  std::vector<std::string> words(const std::string& folder, const std::vector<std::string>& more = {}) const
  {
    std::vector<std::string> all{"rom",        hip_,      "-o",        path(folder), "--flexion",
                                 "-120:20:20", "--varus", "-40:40:20", "--progress", "none"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::string hip_ = VRDA_SOURCE_DIR "/jobs/hip-generic.toml";
};

TEST_F(RomCommand, WritesTheRangeAndWhatEndsIt)
{
  const json found = json::parse(succeed(words("hip", {"--json", "--threads", "1"})).out);
  EXPECT_EQ(found.at("statuses").at("in_range").get<int>() + found.at("statuses").at("contact").get<int>(),
            40);
  // Neck: 50 degrees from -Y to the right, as thick as the sine of 38.7 degrees of the head. Rim: 4.8 degrees
  // above the equator about (0.342, -0.664, 0.664). They meet at a thigh's flexion of 111 degrees.
  const json flexion = found.at("neutral_ends").at("flexion");
  EXPECT_EQ(flexion.at("to").at("ended_by"), "not_tried");
  EXPECT_NEAR(flexion.at("from").at("deg").get<double>(), -100.0, 1e-9);
  EXPECT_EQ(flexion.at("from").at("ended_by"), "contact");
  EXPECT_EQ(flexion.at("from").at("moving"), "head");
  const std::string first = test::text_of(path("hip/rom.json"));
  // The same command again gives the same bytes, with other threads too.
  succeed(words("hip", {"--threads", "2"}));
  EXPECT_EQ(test::text_of(path("hip/rom.json")), first);
  for (const char* name : {"hip/rom.csv", "hip/boundary.csv", "hip/index.html", "hip/rom.png"})
    EXPECT_FALSE(test::text_of(path(name)).empty()) << name;
}

TEST_F(RomCommand, IsRepeatedAtAnglesThatDoNotConvertExactly)
{
  const std::vector<std::string> command{"rom",      hip_,      "-o",    path("fine"), "--flexion",
                                         "-20:20:1", "--varus", "0:5:5", "--progress", "none"};
  succeed(command);
  const std::string first = test::text_of(path("fine/rom.json"));
  succeed(command);
  EXPECT_EQ(test::text_of(path("fine/rom.json")), first);
}

TEST_F(RomCommand, TheResultOfOtherLimitsIsKept)
{
  succeed(words("hip"));
  const std::string before = test::text_of(path("hip/rom.json"));
  test::expect_refused(words("hip", {"--opening-mm", "3"}), {.file = "hip/rom.json", .field = "limits"});
  test::expect_refused(words("hip", {"--set", "title=\"Another\""}),
                       {.file = "hip/rom.json", .field = "job", .found = "Generic hip"});
  EXPECT_EQ(test::text_of(path("hip/rom.json")), before);
  succeed(words("hip", {"--opening-mm", "3", "--replace"}));
  EXPECT_NE(test::text_of(path("hip/rom.json")), before);
}

TEST_F(RomCommand, ShardsAndAResumedRunGiveTheBytesOfAWholeOne)
{
  succeed(words("whole"));
  for (const char* shard : {"1/2", "2/2"}) succeed(words("parts", {"--shard", shard}));
  EXPECT_FALSE(std::filesystem::exists(path("parts/rom.json")));
  // A line that a kill has torn.
  const std::string journal = path("parts/rom.json.shard-2-of-2.journal");
  std::filesystem::resize_file(journal, std::filesystem::file_size(journal) - 5);
  test::expect_refused(words("parts", {"--strain", "0.2"}),
                       {.file = "rom.json.shard-1-of-2.journal", .field = "key"});
  succeed(words("parts"));
  EXPECT_EQ(test::text_of(path("parts/rom.json")), test::text_of(path("whole/rom.json")));
  EXPECT_FALSE(std::filesystem::exists(journal));
}

TEST_F(RomCommand, KilledItGoesOnAndGivesTheBytesOfAWholeOne)
{
  const std::vector<std::string> slow{"--internal", "-40:40:20", "--threads", "1"};
  succeed(words("whole", slow));
  const std::string journal = path("killed/rom.json.journal");
  std::uintmax_t written = 0;
  for (int k = 0; k < 2; ++k) {
    test::Process process(test::vrda(words("killed", slow)));
    test::wait_for_bytes(process, journal, written + 2000);
    ASSERT_TRUE(process.is_running()) << "ended before it could be killed";
    process.send(SIGKILL);
    EXPECT_EQ(process.wait().exit_code, -1);
    EXPECT_FALSE(std::filesystem::exists(path("killed/rom.json")));
    written = std::filesystem::file_size(journal);
  }
  succeed(words("killed", {"--internal", "-40:40:20", "--threads", "2"}));
  EXPECT_EQ(test::sha256_of_file(path("killed/rom.json")), test::sha256_of_file(path("whole/rom.json")));
  EXPECT_FALSE(std::filesystem::exists(journal));
}

TEST_F(RomCommand, ComparesTwoRanges)
{
  succeed(words("narrow"));
  succeed(words("wide", {"--opening-mm", "5", "--translation-mm", "free"}));
  const json found = json::parse(
      succeed({"rom", "--compare", path("narrow/rom.json"), path("wide/rom.json"), "--json"}).out);
  EXPECT_EQ(found.at("only_first").at("attitudes"), 0);
  EXPECT_GT(found.at("only_second").at("attitudes").get<int>(), 0);
  EXPECT_EQ(found.at("both"), found.at("first"));
  EXPECT_FALSE(found.contains("files"));
  succeed({"rom", "--compare", path("narrow/rom.json"), path("wide/rom.json"), "-o", path("both")});
  for (const char* name : {"both/comparison.html", "both/comparison.png", "both/comparison.csv"})
    EXPECT_FALSE(test::text_of(path(name)).empty()) << name;
}

}  // namespace vrda::rom_command_test
