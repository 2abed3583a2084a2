// `vrda score`: grids, tables and models against each other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "support/messages.hpp"

namespace vrda::score_command_test {

using nlohmann::json;

// Digits of an exported table.
constexpr double table_digits = 1e-5;

class ScoreCommand : public test::CommandTest {
 protected:
  /// The model's motion over flexion as a table, the measurement of these tests.
  std::string exported(const std::string& model, const std::string& varus)
  {
    const std::string file = path("motion-" + varus + ".csv");
    const test::Ended ended = test::run_vrda(
        {"export", model, "--to", "csv", "-o", file, "--set", "raw", "--varus", varus, "--quiet"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return file;
  }

  std::string written(const std::string& name, const std::string& text)
  {
    std::ofstream(path(name)) << text;
    return path(name);
  }

  static json scored(std::vector<std::string> words)
  {
    words.insert(words.begin(), "score");
    words.emplace_back("--json");
    const test::Ended ended = test::run_vrda(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return json::parse(ended.out);
  }

  static void expect_refused(std::vector<std::string> words, const test::Refusal& refusal)
  {
    words.insert(words.begin(), "score");
    test::expect_refused(words, refusal);
  }
};

TEST_F(ScoreCommand, AModelAgainstItsOwnExportHasNoError)
{
  for (const std::string side : {"right", "left"}) {
    const std::string model = solved_knee(side);
    const json found = scored({model, "--against", exported(model, "1")});
    EXPECT_EQ(found.at("side"), side);
    EXPECT_EQ(found.at("match"), "flexion");
    EXPECT_EQ(found.at("frames").at("scored"), found.at("frames").at("measured"));
    ASSERT_EQ(found.at("coordinates").size(), 6u);
    for (const auto& [name, of] : found.at("coordinates").items()) {
      // One contact does not determine theta: those rows are listed.
      const std::size_t n = of.at("frames"), n_undetermined = of.at("undetermined_rows").size();
      EXPECT_EQ(n + n_undetermined, 7u) << name;
      EXPECT_EQ(of.at("rms").is_null(), n == 0) << name;
      EXPECT_LT(n == 0 ? 0.0 : of.at("rms").get<double>(), table_digits) << name;
    }
  }
}

TEST_F(ScoreCommand, AnOffsetOfTheFirstHalfIsTakenFromTheSecond)
{
  // clinical numbers of ten frames; the second table is 1 mm further forward, from frame 6 on 3 mm
  std::string measured = "frame,flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n", found = measured;
  for (int k = 1; k <= 10; ++k) {
    const std::string angles =
        std::to_string(k) + "," + std::to_string(5 * k) + ",1," + std::to_string(k % 3);
    measured += angles + "," + std::to_string(k * k) + ",2,3\n";
    found += angles + "," + std::to_string(k * k + (k > 5 ? 3 : 1)) + ",2,3\n";
  }
  const json of = scored({written("found.csv", found), "--against", written("measured.csv", measured),
                          "--align", "constant", "--fit-rows", "first-half", "--rows", "second-half",
                          "--translations", "mesh-origin"});
  const json& anterior = of.at("coordinates").at("anterior");
  EXPECT_EQ(of.at("match"), "key");
  EXPECT_EQ(of.at("key"), "frame");
  EXPECT_EQ(anterior.at("frames"), 5);
  EXPECT_NEAR(anterior.at("offset").get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(anterior.at("rms").get<double>(), 2.0, 1e-9);
  EXPECT_NEAR(anterior.at("shape").get<double>(), 0.0, 1e-9);
  EXPECT_NEAR(of.at("coordinates").at("internal").at("rms").get<double>(), 0.0, 1e-9);
}

TEST_F(ScoreCommand, FramesThatCannotBeScoredAreNamed)
{
  const std::string model = solved_knee("right");
  const std::string table = written("few.csv",
                                    "frame,flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n"
                                    "1,10,0,0,0,0,0\n2,150,0,0,0,0,0\n3,5,0,0,0,0,0\n4,5,60,0,0,0,0\n");
  const json found = scored({model, "--against", table});
  EXPECT_EQ(found.at("frames").at("scored"), 2);
  EXPECT_EQ(found.at("not_scored_rows"), (json{{"outside_range", {2, 4}}}));
  const test::Ended shown = test::run_vrda({"score", model, "--against", table});
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_THAT(shown.out, test::reports("not scored", {"2", "outside_range", "4"}));
  for (const char* name : {"flexion, degree", "varus, degree", "internal, degree", "anterior, mm"})
    EXPECT_NE(shown.out.find(name), std::string::npos) << name;
}

TEST_F(ScoreCommand, ColumnsAndUnitsMayBeStated)
{
  const std::string model = solved_knee("right"), table = path("signed.mot"), bare = path("bare.mot");
  const test::Ended ended =
      test::run_vrda({"export", model, "--to", "mot", "-o", table, "--set", "raw", "--varus", "1",
                      "--coordinate", "flexion=-knee_angle_r", "--quiet"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  std::string text = test::text_of(table);
  text.erase(text.find("negated="), text.find('\n', text.find("negated=")) - text.find("negated="));
  text.replace(text.find("inDegrees=no"), 12, "inRadians=yes");
  written("bare.mot", text);
  const auto rms = [](const json& found) {
    return found.at("coordinates").at("flexion").at("rms").get<double>();
  };
  EXPECT_LT(rms(scored({model, "--against", table, "--column", "flexion=knee_angle_r"})), table_digits);
  EXPECT_LT(rms(scored({model, "--against", bare, "--column", "flexion=-knee_angle_r", "--angles", "rad"})),
            table_digits);
  // Of two tables each column must be in one.
  EXPECT_LT(rms(scored({exported(model, "1"), "--against", table, "--column", "flexion=knee_angle_r",
                        "--match", "flexion"})),
            table_digits);
  // Without a unit: small as degrees, which are assumed.
  expect_refused(
      {model, "--against", bare, "--column", "flexion=-knee_angle_r"},
      {.file = "bare.mot", .field = "column knee_angle_r", .found = "57.2958", .wanted = "--angles rad"});
}

TEST_F(ScoreCommand, MotionsOfDifferentKeysAreNotMatchedInSilence)
{
  const std::string columns = ",flexion_deg,varus_deg,internal_deg,ant_mm,prox_mm,lat_mm\n1,10,0,0,0,0,0\n";
  const std::string by_frame = written("a.csv", "frame" + columns),
                    by_time = written("b.csv", "time_s" + columns);
  expect_refused({by_frame, "--against", by_time},
                 {.file = "a.csv", .field = "key", .found = "frame", .wanted = "time_s"});
  EXPECT_EQ(scored({by_frame, "--against", by_time, "--match", "flexion"}).at("frames").at("scored"), 1);
}

}  // namespace vrda::score_command_test
