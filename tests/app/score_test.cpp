// Motions and measurements: `vrda score`, the offset of `vrda fit`, `vrda repair`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <fstream>
#include <nlohmann/json.hpp>

#include "analysis/repair.hpp"
#include "app/scenes.hpp"
#include "core/text.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::score_test {

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

const std::string key = "reference.component.0.offset_mm";

class Offset : public test::CommandTest {
 protected:
  // The two balls on a dented plate, with the equilibrium as well: both touch at the free varus.
  std::string solved(const std::string& name, const std::vector<std::string>& more)
  {
    std::vector<std::string> words{"run", job_, "-o", path(name), "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    const test::Ended run = test::run_vrda(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return path(name);
  }

  static json printed(const std::vector<std::string>& words, int exit_code = 0)
  {
    const test::Ended ended = test::run_vrda(words);
    EXPECT_EQ(ended.exit_code, exit_code) << ended.err;
    return json::parse(ended.out);
  }

  std::string job_ = test::small_knee_job(scratch_, "right").string();
};

TEST_F(Offset, OfZeroIsTheJobWithoutTheKey)
{
  const std::string bare = solved("bare.h5", {}), zero = solved("zero.h5", {"--set", key + "=0"});
  EXPECT_EQ(test::read_bytes(bare), test::read_bytes(zero));
}

// The audit measures with Bullet and the directional gap, from the file alone.
TEST_F(Offset, LeavesNeitherOverlapNorGap)
{
  for (const std::string method : {"stability-search", "equilibrium"}) {
    SCOPED_TRACE(method);
    const std::string file =
        solved(method + ".h5", {"--set", key + "=0.8", "--set", "solver.method=\"" + method + "\""});
    EXPECT_EQ(test::run_vrda({"audit", file, "--set", "raw"}).exit_code, 0);
    const store::MotionModel model = store::read_motion_model(file);
    EXPECT_THAT(model.reference.contact.mesh.offset_mm, testing::Each(0.8));
    EXPECT_TRUE(model.moving.contact.mesh.offset_mm.empty());
    ASSERT_EQ(model.audits.size(), 1u);
    EXPECT_EQ(model.audits.front().penetration_mm.maxCoeff(), 0.0);
    EXPECT_LE(model.audits.front().gap_mm.maxCoeff(), model.contact_resolution_mm);
    EXPECT_GT(model.contacts.distance_mm.size(), 0u);
  }
}

TEST_F(Offset, ScalesAsALength)
{
  const store::MotionModel twice =
      store::read_motion_model(solved("twice.h5", {"--set", key + "=0.8", "--set", "scaling.factor=2"}));
  EXPECT_THAT(twice.reference.contact.mesh.offset_mm, testing::Each(1.6));
}

TEST_F(Offset, IsFoundFromASyntheticMotion)
{
  const std::string motion =
      solved("motion.h5", {"--set", key + "=1.3", "--set", "solver.method=\"equilibrium\""});
  const json found = printed({"fit", job_, "--set", key + "=\"fit\"", "--motion", motion, "--rows",
                              "first-half", "-o", path("fitted.toml"), "--json"});
  EXPECT_EQ(found.at("status"), "converged");
  EXPECT_NEAR(found.at("offset_mm"), 1.3, 1e-3);  // gaps of up to the contact resolution of 1e-5 mm remain
  EXPECT_LT(found.at("other_gap_rms_mm"), 1e-3);
  EXPECT_GT(found.at("bare_gap_rms_mm"), 1.0);
  // The file written is a job with the number.
  EXPECT_THAT(test::read_bytes(path("fitted.toml")), testing::HasSubstr("offset_mm = 1.3"));
}

// A motion whose objects never face each other does not depend on the offset.
TEST_F(Offset, IsUndeterminedByAMotionWithoutContact)
{
  std::ofstream(path("aside.csv")) << "frame,flexion_deg,varus_deg,internal_deg,tx_mm,ty_mm,tz_mm\n"
                                      "1,0,0,0,400,-20,0\n2,5,0,0,400,-20,0\n3,8,0,0,400,-20,0\n";
  const json found =
      printed({"fit", job_, "--set", key + "=\"fit\"", "--motion", path("aside.csv"), "--json"}, 3);
  EXPECT_EQ(found.at("status"), "undetermined");
  EXPECT_TRUE(found.at("standard_error_mm").is_null());
}

class RepairCommand : public test::CommandTest {
 protected:
  /// Solved poses of the two-ball knee, pushed together by 1.2 mm in the middle and apart by 0.8 mm at the
  /// end.
  std::string measured_walk(const std::string& side)
  {
    const std::string job = test::small_knee_job(scratch_, side).string(), grid_file = path("grid.h5");
    succeed({"run", job, "-o", grid_file, "--progress", "none", "--replace"});
    const store::MotionModel grid = store::read_motion_model(grid_file);
    std::string text = "time,T11,T12,T13,T14,T21,T22,T23,T24,T31,T32,T33,T34\n";
    int frame = 0;
    for (const std::size_t i : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 5u}) {
      Pose X = store::pose_in(grid.X_reference_moving, 5 * i + 2);
      X.translation().y() += frame == 7 ? -0.8 : frame >= 3 && frame <= 5 ? 1.2 : 0.0;
      text += shortest_decimal(0.25 * frame++);
      for (Eigen::Index k = 0; k < 12; ++k) text += "," + shortest_decimal(X.matrix()(k / 4, k % 4));
      text += "\n";
    }
    const std::string table = scratch_.write("walk.csv", text).string(), file = path("measured.h5");
    const test::Ended imported =
        succeed({"import", job, "--motion", table, "-o", file, "--unit", "mm", "--direction",
                 "moving-in-reference", "--axes", "canonical", "--side", side, "--replace"});
    EXPECT_THAT(imported.err, testing::HasSubstr("of 8 frames, by at most 1.2 mm at time_s"));
    return file;
  }

  std::vector<std::string> repair_words(const std::string& file, const std::string& output) const
  {
    return {"repair", file, "-o", output, "--noise-mm", "0.5", "--noise-deg", "1,1,0.5", "--gap-mm", "0"};
  }
};

TEST_F(RepairCommand, NothingOverlapsAndTheMeasuredPosesAreKept)
{
  for (const std::string side : {"right", "left"}) {
    SCOPED_TRACE(side);
    const std::string file = measured_walk(side), output = path("repaired_" + side + ".h5");
    std::vector<std::string> words = repair_words(file, output);
    words.emplace_back("--json");
    const json found = json::parse(succeed(words).out);
    EXPECT_GE(found["before"]["overlapping"], 3);
    EXPECT_GT(found["before"]["largest_penetration_mm"], 1.0);
    EXPECT_GT(found["before"]["largest_gap_mm"], 0.5);
    EXPECT_LE(found["after"]["largest_penetration_mm"], analysis::repair_tolerance_mm);
    EXPECT_LE(found["after"]["largest_gap_mm"], analysis::repair_tolerance_mm + 0.1);
    EXPECT_EQ(found["statuses"]["not_converged"], 0);
    EXPECT_EQ(found["frames"].size(), 8u);
    succeed({"validate", output});
    const store::MotionModel measured = store::read_motion_model(file),
                             model = store::read_motion_model(output);
    ASSERT_TRUE(model.repair);
    EXPECT_EQ(model.repair->X_measured, measured.X_reference_moving);
    EXPECT_NE(model.X_reference_moving, measured.X_reference_moving);
    EXPECT_EQ(model.frames->key, measured.frames->key);
    EXPECT_EQ(model.repair->noise_deg[2], 0.5);
    // Measured again from the file's meshes and poses.
    const json info = test::json_of({"audit", output});
    EXPECT_TRUE(info[0]["largest_penetration"].is_null() ||
                info[0]["largest_penetration"]["mm"] <= analysis::repair_tolerance_mm);
    // A repair of a repair starts from the measurement.
    const std::string again = path("again_" + side + ".h5");
    succeed(repair_words(output, again));
    EXPECT_EQ(store::read_motion_model(again).X_reference_moving, model.X_reference_moving);
  }
}

TEST_F(RepairCommand, AnOutputIsReplacedOnRequest)
{
  const std::string file = measured_walk("right"), output = path("out.h5");
  succeed(repair_words(file, output));
  test::expect_refused(repair_words(file, output), {.file = output, .wanted = "--replace"});
  std::vector<std::string> words = repair_words(file, output);
  words.emplace_back("--replace");
  succeed(words);
}

}  // namespace vrda::score_test
