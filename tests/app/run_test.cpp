#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
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

TEST(Run, ThreadsAndProcessorFeaturesChangeNoByte)
{
  const test::Scratch scratch;
  const std::string job = test::small_knee_job(scratch, "right").string();
  std::vector<std::string> hashes;
  for (const std::string threads : {"1", "2", "5"}) {
    const fs::path output = scratch.path() / (threads + ".h5");
    ASSERT_EQ(test::run_vrda({"run", job, "-o", output.string(), "--threads", threads}).exit_code, 0);
    hashes.push_back(test::sha256_of_file(output));
  }
  test::Command plain = test::vrda({"run", job, "-o", (scratch.path() / "plain.h5").string()});
  plain.environment["GLIBC_TUNABLES"] = "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable";
  ASSERT_EQ(test::run(plain).exit_code, 0);
  hashes.push_back(test::sha256_of_file(scratch.path() / "plain.h5"));
  EXPECT_THAT(hashes, testing::Each(hashes[0]));
}

TEST(Run, KilledThreeTimesItGoesOnAndGivesTheSameBytes)
{
  const test::Scratch scratch;
  const std::string job = test::longer_knee_job(scratch).string();
  const fs::path whole = scratch.path() / "whole.h5", killed = scratch.path() / "killed.h5";
  const fs::path journal = killed.string() + ".journal";
  ASSERT_EQ(test::run_vrda({"run", job, "-o", whole.string()}).exit_code, 0);
  std::uintmax_t written = 0;
  for (int k = 0; k < 3; ++k) {
    test::Process process(test::vrda({"run", job, "-o", killed.string()}));
    test::wait_for_bytes(process, journal, written + 3000);
    ASSERT_TRUE(process.is_running()) << "ended before it could be killed";
    process.send(SIGKILL);
    EXPECT_EQ(process.wait().exit_code, -1);
    ASSERT_TRUE(fs::exists(journal));
    EXPECT_FALSE(fs::exists(killed));
    written = fs::file_size(journal);
    EXPECT_THAT(store::validate_hdf5(killed.string() + ".start.h5"), IsEmpty());
  }
  const test::Ended last = test::run_vrda({"run", job, "-o", killed.string()});
  EXPECT_EQ(last.exit_code, 0);
  EXPECT_THAT(last.err, test::reports("resuming", journal.string()));
  EXPECT_EQ(test::sha256_of_file(killed), test::sha256_of_file(whole));
}

TEST(Run, AnInterruptFinishesTheStepsInHandAndIsResumable)
{
  const test::Scratch scratch;
  const std::string job = test::longer_knee_job(scratch).string();
  const fs::path output = scratch.path() / "knee.h5", journal = output.string() + ".journal";
  std::signal(SIGHUP, SIG_DFL);  // as if not under nohup
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    test::Process process(test::vrda({"run", job, "-o", output.string()}));
    test::wait_for_bytes(process, journal, (fs::exists(journal) ? fs::file_size(journal) : 0) + 2000);
    process.send(signal);
    const test::Ended ended = process.wait();
    EXPECT_EQ(ended.exit_code, 4);
    EXPECT_THAT(ended.err, test::reports("interrupted", journal.string()));
  }
  EXPECT_EQ(test::run_vrda({"run", job, "-o", output.string()}).exit_code, 0);
}

TEST(Run, ADamagedTailIsDroppedWithAMessageAndSolvedAgain)
{
  const test::Scratch scratch;
  const std::string job = test::longer_knee_job(scratch).string();
  const fs::path whole = scratch.path() / "whole.h5", output = scratch.path() / "knee.h5";
  ASSERT_EQ(test::run_vrda({"run", job, "-o", whole.string()}).exit_code, 0);
  const fs::path journal = output.string() + ".journal";
  {
    test::Process process(test::vrda({"run", job, "-o", output.string()}));
    test::wait_for_bytes(process, journal, 6000);
    process.send(SIGKILL);
    process.wait();
  }
  std::string bytes = test::read_bytes(journal);
  ASSERT_GT(bytes.size(), 4000u);
  bytes.resize(bytes.size() - 1000);
  bytes[bytes.size() - 200] = static_cast<char>(bytes[bytes.size() - 200] ^ 0x10);
  scratch.write("knee.h5.journal", bytes);
  const test::Ended ended = test::run_vrda({"run", job, "-o", output.string()});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, test::warns(journal.string()));
  EXPECT_EQ(test::sha256_of_file(output), test::sha256_of_file(whole));
}

TEST(Run, AMirroredLeftKneeGivesTheSameClinicalNumbersToTheLastBit)
{
  const test::Scratch scratch;
  const std::string right = (scratch.path() / "right.h5").string(),
                    left = (scratch.path() / "left.h5").string();
  ASSERT_EQ(test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o", right}).exit_code,
            0);
  ASSERT_EQ(test::run_vrda({"run", test::small_knee_job(scratch, "left").string(), "-o", left}).exit_code, 0);
  const store::MotionModel r = store::read_motion_model(right), l = store::read_motion_model(left);
  ASSERT_EQ(r.side, "right");
  ASSERT_EQ(l.side, "left");
  EXPECT_TRUE((r.status == l.status).all());
  EXPECT_TRUE((r.clinical.internal_rotation_deg == l.clinical.internal_rotation_deg).all());
  EXPECT_TRUE((r.clinical.flexion_deg == l.clinical.flexion_deg).all());
  EXPECT_TRUE((r.clinical.varus_deg == l.clinical.varus_deg).all());
  EXPECT_TRUE((r.clinical.anterior_mm == l.clinical.anterior_mm).all());
  EXPECT_TRUE((r.clinical.proximal_mm == l.clinical.proximal_mm).all());
  EXPECT_TRUE((r.clinical.lateral_mm == l.clinical.lateral_mm).all());
  EXPECT_TRUE((r.gap_medial_mm == l.gap_medial_mm).all());
  EXPECT_TRUE((r.tz_mm == -l.tz_mm).all());
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
