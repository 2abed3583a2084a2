// `vrda rom` on a coarse range of the generic hip; `vrda laxity` and `vrda fit --to` on the generic knee.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "support/messages.hpp"
#include "support/refusal.hpp"

namespace vrda::rom_test {

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
  test::Process process(test::vrda(words("killed", slow)));
  test::wait_for_bytes(process, journal, 2000);
  ASSERT_TRUE(process.is_running()) << "ended before it could be killed";
  process.send(SIGKILL);
  EXPECT_EQ(process.wait().exit_code, -1);
  EXPECT_FALSE(std::filesystem::exists(path("killed/rom.json")));
  succeed(words("killed", {"--internal", "-40:40:20", "--threads", "2"}));
  EXPECT_EQ(test::sha256_of_file(path("killed/rom.json")), test::sha256_of_file(path("whole/rom.json")));
  EXPECT_FALSE(std::filesystem::exists(journal));
}

TEST_F(RomCommand, ComparesTwoRanges)
{
  succeed(words("narrow"));
  succeed(words("wide", {"--opening-mm", "5", "--translation-mm", "free"}));
  const json found = test::json_of({"rom", "--compare", path("narrow/rom.json"), path("wide/rom.json")});
  EXPECT_EQ(found.at("only_first").at("attitudes"), 0);
  EXPECT_GT(found.at("only_second").at("attitudes").get<int>(), 0);
  EXPECT_EQ(found.at("both"), found.at("first"));
  EXPECT_FALSE(found.contains("files"));
  succeed({"rom", "--compare", path("narrow/rom.json"), path("wide/rom.json"), "-o", path("both")});
  for (const char* name : {"both/comparison.html", "both/comparison.png", "both/comparison.csv"})
    EXPECT_FALSE(test::text_of(path(name)).empty()) << name;
}

class LaxityCommand : public test::CommandTest {
 protected:
  void SetUp() override
  {
    const std::string knee = test::text_of(VRDA_SOURCE_DIR "/jobs/knee-generic.toml");
    scratch_.write("plain.toml", knee);
    scratch_.write("knee.toml", knee + test::laxity_tables + test::fit_tables);
  }
  test::Ended run(std::vector<std::string> words) const
  {
    words.insert(words.end(), {"--progress", "none"});
    return test::run_vrda(words);
  }
};

TEST_F(LaxityCommand, WritesTablesOfTheWholeKneeAndWithoutTheAcl)
{
  const test::Ended ended = run({"laxity", path("knee.toml"), "-o", path("a"), "--json", "--threads", "1"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const json found = json::parse(ended.out);
  EXPECT_EQ(found.at("states"), json({"intact", "ACL"}));
  ASSERT_EQ(found.at("curves").size(), 8u);
  for (std::size_t flexion = 0; flexion < 2; ++flexion) {
    const json& whole = found.at("curves").at(2 * flexion);
    const json& cut = found.at("curves").at(4 + 2 * flexion);
    ASSERT_EQ(whole.at("test"), "anterior");
    ASSERT_EQ(cut.at("state"), "ACL");
    double share = 0.0, sum = whole.at("contact").at("share");
    for (const json& bundle : whole.at("bundles")) {
      const double part = bundle.at("share");
      sum += part;
      if (bundle.at("name").get<std::string>().starts_with("ACL")) share += part;
    }
    EXPECT_NEAR(sum, 1.0, 1e-3);
    EXPECT_GT(share, 0.05);
    EXPECT_GT(cut.at("laxity").get<double>(), whole.at("laxity").get<double>());
    EXPECT_LT(cut.at("replaced").at("distance_mm").get<double>(), 0.01);
  }
  // The same bytes again, with other threads; every file.
  const std::string first = test::text_of(path("a/laxity.json"));
  EXPECT_EQ(run({"laxity", path("knee.toml"), "-o", path("a"), "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(test::text_of(path("a/laxity.json")), first);
  for (const char* name : {"a/index.html", "a/laxity.csv", "a/share.csv"})
    EXPECT_FALSE(test::text_of(path(name)).empty()) << name;
  // Its own table is met exactly.
  const test::Ended against =
      run({"laxity", path("knee.toml"), "-o", path("a"), "--against", path("a/laxity.csv"), "--json"});
  ASSERT_EQ(against.exit_code, 0) << against.err;
  const json compared = json::parse(against.out);
  for (const json& row : compared.at("published")) EXPECT_NEAR(row.at("difference").get<double>(), 0.0, 1e-9);
}

TEST_F(LaxityCommand, AFitToALaxityFindsTheStrainThatMadeIt)
{
  // The knee whose ACLpl is 0.02 tighter: the fitted job of a made-up result.
  ASSERT_EQ(run({"laxity", path("knee.toml"), "-o", path("a")}).exit_code, 0);
  std::string table = test::text_of(path("a/laxity.csv"));
  scratch_.write("measured.csv", table);
  const std::vector<std::string> fit{"fit", path("knee.toml"),   "--to",  path("measured.csv"),
                                     "-o",  path("fitted.toml"), "--json"};
  const test::Ended ended = run(fit);
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  // Its own laxity: nothing changes. A varus moment is not seen in the anterior laxity.
  const json found = json::parse(ended.out);
  EXPECT_EQ(found.at("status"), "converged");
  EXPECT_NEAR(found.at("unknowns").at(0).at("change").get<double>(), 0.0, 1e-3);
  EXPECT_EQ(found.at("unknowns").at(0).at("name"), "reference_strain ACLpl");
  EXPECT_EQ(found.at("unknowns").at(0).at("decision"), "decided");
  EXPECT_EQ(found.at("unknowns").at(1).at("name"), "varus_moment");
  EXPECT_FALSE(test::text_of(path("fitted.ligaments.csv")).empty());
  EXPECT_FALSE(test::text_of(path("fitted.fit.json")).empty());
  // The fitted job is a job of its own.
  EXPECT_EQ(run({"laxity", path("fitted.toml"), "-o", path("c")}).exit_code, 0);
}

TEST_F(LaxityCommand, AFitReplacesNoFileThatIsNotItsOwn)
{
  scratch_.write("motion.csv",
                 "flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n10,0,0,0,0,0\n20,0,0,0,0,0\n");
  const std::string job = test::text_of(path("knee.toml"));
  const auto fitted = [&](const std::string& from, const std::string& to,
                          std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"fit", path(from), "--to", path("motion.csv"), "-o", path(to)});
    return run(more);
  };
  EXPECT_THAT(fitted("knee.toml", "knee.toml"),
              test::refuses({.file = "knee.toml", .field = "--output", .wanted = "--replace"}));
  EXPECT_EQ(test::text_of(path("knee.toml")), job);
  scratch_.write("other.toml", "keep");
  EXPECT_THAT(fitted("knee.toml", "other.toml"), test::refuses({.file = "other.toml", .field = "--output"}));
  EXPECT_EQ(test::text_of(path("other.toml")), "keep");
  EXPECT_NE(fitted("knee.toml", "first.toml").exit_code, 2);
  // Its own result again, but neither as input nor that of another job.
  EXPECT_NE(fitted("knee.toml", "first.toml").exit_code, 2);
  const std::string first = test::text_of(path("first.ligaments.csv"));
  scratch_.write("again.toml", test::text_of(path("first.toml")) + test::fit_tables);
  EXPECT_THAT(fitted("again.toml", "first.toml"), test::refuses({.file = "first.toml", .field = "--output"}));
  EXPECT_EQ(test::text_of(path("first.ligaments.csv")), first);
  EXPECT_NE(fitted("knee.toml", "other.toml", {"--replace"}).exit_code, 2);
  EXPECT_NE(test::text_of(path("other.toml")), "keep");
}

}  // namespace vrda::rom_test
