// `vrda run`: its files, its messages, and the motion that it chooses to show.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/scenes.hpp"
#include "core/console.hpp"
#include "core/text.hpp"
#include "run/run_output.hpp"
#include "solve/case_solver.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::run_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::AllOf;
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
  // Jobs of one file name in folders of their own, as `vrda prepare` makes them, have outputs of their own.
  struct Row {
    const char *folder, *expected;
  };
  for (const Row& row : {Row{"jobs", "small/small"}, Row{"anna", "anna-small/anna-small"},
                         Row{"ben/left", "ben-left-small/ben-left-small"},
                         Row{"old/ben/left", "ben-left-small/ben-left-small"},
                         Row{"so-small", "so-small/so-small"}, Row{"ben/jobs/x", "x-small/x-small"}}) {
    const std::string job = (scratch.path() / row.folder / "small.toml").string();
    fs::create_directories(fs::path(job).parent_path());
    for (const char* name : {"small.toml", "ball.stl", "dish.stl"}) {
      if (fs::exists(scratch.path() / name))
        fs::copy(scratch.path() / name, fs::path(job).parent_path() / name);
    }
    fs::remove_all(scratch.path() / "results");
    command.arguments = {"run", job, "--quiet"};
    EXPECT_EQ(test::run(command).out, std::string("results/") + row.expected + ".h5\n");
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

TEST(Assemble, OnlyStableCellsHoldNumbers)
{
  const test::Scratch scratch;
  const job::Case job_case = job::load_case(test::small_knee_job(scratch, "left").string());
  solve::SweepResult result;
  result.cells.resize(35);
  result.spine_column.assign(7, 2);
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 5; ++j) {
      StepRecord& r = result.cells[static_cast<std::size_t>(5 * i + j)];
      r.key = {StepKind::row, i, j};
      r.status = j == 4 ? StepStatus::no_contact : StepStatus::stable;
      r.varus_rad = rad_from_deg(j - 2.0);
      r.pose = {{1.0 * i, 2.0 * j, 3.0}, 0.1};
      if (j != 4) r.contacts.push_back({{1, 2, 3}, {0, -1, 0}, 0.01, 4, 5, 1});
    }
  }
  const store::MotionModel model = solve::motion_model_of(job_case, result);
  EXPECT_EQ(run::status_line(model), "35 attitudes: 7 no_contact, 28 stable");
  EXPECT_NEAR(run::unsolved_fraction(model), 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(model.theta_deg(3, 4)));
  EXPECT_EQ(model.tz_mm(3, 3), -3.0) << "a left knee is reflected back to its own side";
  EXPECT_EQ(model.contacts.point_world_mm(0, 2), -3.0);
  EXPECT_EQ(model.contacts.row_start.back(), 28);
  EXPECT_EQ(model.is_spine.cast<int>().sum(), 7);
  // The decomposition of the stored pose returns the grid attitudes.
  EXPECT_NEAR(model.clinical[JointCoordinate::flexion](3, 1), 6.0, 1e-9);
  EXPECT_NEAR(model.clinical[JointCoordinate::varus](3, 1), -1.0, 1e-9);
}

constexpr double table_digits_deg = 1e-9;

std::string exported(const std::string& file, const std::string& name, const std::vector<std::string>& more)
{
  const std::vector<std::string> words{"export", file, "--to", name.substr(name.size() - 3), "-o", name};
  EXPECT_EQ(test::run_vrda(words, more).exit_code, 0);
  return test::text_of(name);
}

/// What follows the first line, which has the title, the set and the reason.
std::string without_name(const std::string& text)
{
  return text.substr(text.find('\n'));
}

// A smoothed motion that compare rejects is neither shown nor exported; the reason is said everywhere.
TEST(DefaultMotion, IsTheSmoothedOneOnlyIfItMeetsTheCriteriaOfCompare)
{
  struct Row {
    std::string degrees, fault, set;
  };
  for (const Row& row : {Row{"1,2", "none", "two_sided"}, Row{"3", "rough", "raw"}}) {
    SCOPED_TRACE(row.degrees);
    const test::Scratch scratch;
    const std::string file = (scratch.path() / "knee.h5").string(),
                      table = (scratch.path() / "a.sto").string();
    const test::Ended run = test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o",
                                            file, "--set", "smooth.degrees=[" + row.degrees + "]"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("default motion: " + row.set));
    EXPECT_THAT(run.err, HasSubstr("screw-home along the spine: internal rotation net"));
    const Json compared = test::json_of({"compare", file, "--degrees", row.degrees, "--quiet"});
    EXPECT_EQ(compared.at("degrees").back().at("fault"), row.fault);
    const Json shown = test::json_of({"info", file}).at("default_motion");
    EXPECT_EQ(shown.at("set"), row.set);
    EXPECT_EQ(shown.at("is_compared"), true);
    const std::string reason = shown.at("reason");
    EXPECT_EQ(reason.empty(), row.fault == "none");
    EXPECT_THAT(run.err, HasSubstr(reason));
    const std::string text = exported(file, table, {});
    EXPECT_THAT(text.substr(0, text.find('\n')),
                testing::EndsWith(row.set + (reason.empty() ? "" : ": " + reason)));
    EXPECT_EQ(without_name(text), without_name(exported(file, table, {"--set", row.set})));
    EXPECT_EQ(test::run_vrda({"validate", file}).exit_code, 0);
  }
}

// The solved motion is exported along the spine; how it turns and where it jumps is in `run` and `info`.
TEST(DefaultMotion, OfSolvedPosesIsTheSpineAndItsJumpsAreNamed)
{
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "knee.h5").string(), table = (scratch.path() / "a.mot").string();
  const test::Ended run =
      test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o", file, "--set",
                      "smooth.degrees=[1]", "--set", "grid.flexion={ from = 0, to = 60, step = 5 }"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json info = test::json_of({"info", file});
  const Json &spine = info.at("screw_home").at("spine"), &net = info.at("screw_home").at("net");
  std::istringstream rows(exported(file, table, {"--degrees"}));
  for (std::string line; line.rfind("time", 0) != 0;) ASSERT_TRUE(std::getline(rows, line));
  double time_s = 0.0, flexion_deg = 0.0, varus_deg = 0.0, internal_deg = 0.0, tx_m = 0.0, ty_m = 0.0,
         tz_m = 0.0;
  std::size_t row = 0;
  for (; rows >> time_s >> flexion_deg >> varus_deg >> internal_deg >> tx_m >> ty_m >> tz_m; ++row) {
    EXPECT_NEAR(flexion_deg, spine.at(row).at("flexion_deg").get<double>(), table_digits_deg);
    EXPECT_NEAR(internal_deg, spine.at(row).at("internal_rotation_deg").get<double>(), table_digits_deg);
  }
  EXPECT_EQ(row, spine.size());
  EXPECT_NEAR(net.at("deg").get<double>(),
              internal_deg - spine.front().at("internal_rotation_deg").get<double>(), table_digits_deg);
  EXPECT_GT(info.at("jump").at("perceptible_errors"), 10.0);
  EXPECT_LT(info.at("jump").at("from_flexion_deg"), info.at("jump").at("to_flexion_deg"));
  for (const std::string& text : {run.err, test::run_vrda({"info", file}).out})
    EXPECT_THAT(text, AllOf(HasSubstr("the raw motion jumps by"), HasSubstr("theta jumps by")));
  EXPECT_GT(info.at("spine_jump").at("deg"), 3.0);
}

// Without a two-sided motion the set that `smooth` adds is the new candidate.
TEST(DefaultMotion, IsDecidedAgainBySmooth)
{
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "ball.h5").string();
  ASSERT_EQ(test::run_vrda({"run", test::small_job(scratch).string(), "-o", file}).exit_code, 0);
  EXPECT_THAT(test::json_of({"info", file}).at("default_motion").at("reason").get<std::string>(),
              testing::StartsWith("degree_1_recontacted "));
  ASSERT_EQ(test::run_vrda({"smooth", file, "--degree", "2"}).exit_code, 0);
  EXPECT_THAT(test::json_of({"info", file}).at("default_motion").at("reason").get<std::string>(),
              testing::StartsWith("degree_2 "));
}

TEST(Progress, AClockThatWasSetSaysNothingAbsurd)
{
  // Hours back, unchanged, and the largest step of a 64-bit clock: 292 years.
  EXPECT_EQ(core::rate_text(5, -7200.0, 10), "starting");
  EXPECT_EQ(core::rate_text(5, 0.0, 10), "starting");
  EXPECT_EQ(core::rate_text(1, 9.2e9, 1'000'000), "1.09e-10/s, 153333333333333:20 left");
}

TEST(Progress, StylesByName)
{
  EXPECT_EQ(core::progress_style_of("bar"), core::ProgressStyle::bar);
  EXPECT_EQ(core::progress_style_of("plain"), core::ProgressStyle::plain);
  EXPECT_EQ(core::progress_style_of("none"), core::ProgressStyle::none);
  try {
    core::progress_style_of("fast");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "--progress: found fast, wanted auto, bar, plain or none");
  }
}

}  // namespace vrda::run_test
