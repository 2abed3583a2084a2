// `vrda laxity` and `vrda fit --to` on the generic knee: files, a fit to a measured laxity,
// continuation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "support/messages.hpp"
#include "support/refusal.hpp"

namespace vrda::laxity_command_test {

using nlohmann::json;

class LaxityCommand : public testing::Test {
 protected:
  void SetUp() override
  {
    const std::string knee = test::text_of(VRDA_SOURCE_DIR "/jobs/knee-generic.toml");
    scratch_.write("plain.toml", knee);
    scratch_.write("knee.toml", knee + test::laxity_tables + test::fit_tables);
  }
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }
  test::Ended run(std::vector<std::string> words) const
  {
    words.insert(words.end(), {"--progress", "none"});
    return test::run_vrda(words);
  }

  test::Scratch scratch_;
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

}  // namespace vrda::laxity_command_test
