#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::run_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Run, WritesTheModelAndCleansUp)
{
  const test::Scratch scratch;
  const fs::path output = scratch.path() / "deep" / "folder" / "small.h5";
  const test::Ended ended = test::run_vrda({"run", test::small_job(scratch).string(), "-o", output.string()});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.out, output.string() + "\n");
  EXPECT_THAT(ended.err, test::reports("15 attitudes", {"15", "stable"}));
  EXPECT_TRUE(fs::exists(output));
  EXPECT_FALSE(fs::exists(output.string() + ".journal"));
  EXPECT_FALSE(fs::exists(output.string() + ".start.h5"));
  const auto record = nlohmann::json::parse(test::read_bytes(output.string() + ".run.json"));
  EXPECT_GT(record["seconds"].get<double>(), 0.0);
  EXPECT_EQ(record["steps_recalled"], 0);
  EXPECT_THAT(store::validate_hdf5(output.string()), IsEmpty());
}

TEST(Run, TheProfileHasEveryPhaseAndTheirSum)
{
  const test::Scratch scratch;
  const test::Ended ended = test::run_vrda(
      {"run", test::small_job(scratch).string(), "-o", (scratch.path() / "small.h5").string(), "--profile"});
  EXPECT_EQ(ended.exit_code, 0);
  double sum_s = 0.0, all_s = 0.0;
  for (const std::string name :
       {"solving", "plausibility", "smoothing, recontact", "two-sided, zero varus", "writing", "all"}) {
    const std::size_t at = ended.err.find("\n" + name + ' ');
    ASSERT_NE(at, std::string::npos) << name;
    (name == "all" ? all_s : sum_s) += std::stod(ended.err.substr(at + 1 + name.size()));
  }
  EXPECT_NEAR(sum_s, all_s, 0.05);  // six numbers rounded to hundredths, and the removal of journals
}

TEST(Run, TheDefaultOutputIsNamedAfterTheJob)
{
  const test::Scratch scratch;
  test::Command command = test::vrda({"run", test::small_job(scratch).string(), "--quiet"});
  command.folder = scratch.path();
  const test::Ended ended = test::run(command);
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_EQ(ended.out, "results/small/small.h5\n");
  EXPECT_THAT(ended.err, IsEmpty());
  EXPECT_TRUE(fs::exists(scratch.path() / "results/small/small.h5"));
}

TEST(Run, AMirroredLeftKneeGivesTheSameClinicalNumbersToTheLastBit)
{
  const test::Scratch scratch;
  const auto solved = [&](const std::string& side, const std::vector<std::string>& more) {
    const std::string file = (scratch.path() / (side + ".h5")).string();
    std::vector<std::string> words{"run", test::small_knee_job(scratch, side).string(), "-o", file,
                                   "--replace"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
    return store::read_motion_model(file);
  };
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"--set", "solver.method=equilibrium", "--set", "grid.varus=free"}}) {
    SCOPED_TRACE(testing::PrintToString(more));
    const store::MotionModel r = solved("right", more), l = solved("left", more);
    ASSERT_EQ(r.side, "right");
    ASSERT_EQ(l.side, "left");
    EXPECT_TRUE((r.status == l.status).all());
    for (const auto surface :
         {&store::ClinicalSurfaces::internal_rotation_deg, &store::ClinicalSurfaces::flexion_deg,
          &store::ClinicalSurfaces::varus_deg, &store::ClinicalSurfaces::anterior_mm,
          &store::ClinicalSurfaces::proximal_mm, &store::ClinicalSurfaces::lateral_mm})
      EXPECT_TRUE((r.clinical.*surface == l.clinical.*surface).all());
    EXPECT_TRUE((r.varus_solved_deg == l.varus_solved_deg).all());
    EXPECT_TRUE((r.gap_medial_mm == l.gap_medial_mm).all());
    EXPECT_TRUE((r.tz_mm == -l.tz_mm).all());
    EXPECT_TRUE(!r.equilibrium || (r.equilibrium->energy_nmm == l.equilibrium->energy_nmm).all());
  }
}

TEST(Run, MoreUnsolvedThanAllowedExitsWithThree)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string(), output = (scratch.path() / "limit.h5").string();
  const test::Ended refused =
      test::run_vrda({"run", job, "-o", output, "--set", "solver.search.max_steps=2"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, test::warns("limits.unsolved_fraction"));
  EXPECT_THAT(refused.err, test::reports("15 attitudes", "iteration_limit"));
  EXPECT_TRUE(fs::exists(output));
  const test::Ended allowed = test::run_vrda({"run", job, "-o", output, "--set", "solver.search.max_steps=2",
                                              "--set", "limits.unsolved_fraction=1"});
  EXPECT_EQ(allowed.exit_code, 0);
}

TEST(Run, ADegreeTheGridCannotCarryIsLeftOutWithAWarning)
{
  const test::Scratch scratch;
  const std::string output = (scratch.path() / "small.h5").string();
  const test::Ended ended = test::run_vrda(
      {"run", test::small_job(scratch).string(), "-o", output, "--set", "smooth.degrees=[1, 6]"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, test::warns("smooth.degrees", "6"));
  const store::MotionModel model = store::read_motion_model(output);
  ASSERT_EQ(model.smoothed.size(), 1u);
  EXPECT_EQ(model.smoothed[0].degree, 1);
}

TEST(Run, ProgressIsPlainLinesOffATerminalAndSilentOnDemand)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string(), output = (scratch.path() / "small.h5").string();
  EXPECT_THAT(test::run_vrda({"run", job, "-o", output}).err, test::reports("", "15/15"));
  EXPECT_THAT(test::run_vrda({"run", job, "-o", output, "--progress", "none", "--fresh"}).err,
              testing::Not(test::reports("", "15/15")));
  EXPECT_THAT(test::run_vrda({"run", job, "-o", output, "--progress", "bar", "--fresh"}).err,
              HasSubstr("####"));
}

}  // namespace vrda::run_test
