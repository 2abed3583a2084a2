// The jobs of the repository on coarse grids: each must give correct statuses, poses without overlap and no
// warning but those of shipped_warnings.cpp. validation_jobs_test.cpp has those of jobs/validation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/audit.hpp"
#include "app/scenes.hpp"
#include "app/shipped_warnings.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"
#include "support/real_knees.hpp"

namespace vrda::jobs_test {

namespace fs = std::filesystem;
using testing::IsEmpty;

const std::vector<std::string> coarse_grid{"--set", "grid.flexion={from=0, to=90, step=45}",
                                           "--set", "grid.varus={from=-5, to=5, step=5}",
                                           "--set", "smooth.degrees=[2]"};

store::MotionModel solved(const test::Scratch& scratch, const std::string& job,
                          std::vector<std::string> words)
{
  const std::string file = (test::source_directory() / "jobs" / job).string();
  const std::string output = (scratch.path() / (job + std::to_string(words.size()) + ".h5")).string();
  words.insert(words.begin(), {"run", file, "-o", output, "--progress", "none", "--fresh"});
  const test::Ended ended = test::run_vrda(words);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  test::expect_known_warnings(fs::path(job).stem(), "run", ended);
  EXPECT_THAT(store::validate_hdf5(output), IsEmpty());
  return store::read_motion_model(output);
}

void expect_clean_poses(const store::MotionModel& model)
{
  EXPECT_EQ(run::cells_by_status(model).count("pending"), 0u);
  EXPECT_GT(run::cells_by_status(model)["stable"], 0);
  const analysis::AuditFigures measured = analysis::figures_of(analysis::audit(model, "raw", 1, 2));
  EXPECT_EQ(measured.n_overlapping, 0);
  EXPECT_EQ(measured.n_nothing_ahead, 0);
  EXPECT_LE(measured.largest_gap.value_mm, model.contact_resolution_mm);
}

// At every attitude; contact within the margin plus the same amount for rounding of poses.
void expect_recontacted(const store::MotionModel& model)
{
  ASSERT_EQ(model.smoothed.size(), 1u);
  const std::string set = "degree_" + std::to_string(model.smoothed.front().degree);
  const analysis::AuditFigures measured =
      analysis::figures_of(analysis::audit(model, set + "_recontacted", 1, 2));
  EXPECT_EQ(measured.n_poses, model.status.size());
  EXPECT_EQ(measured.n_overlapping, 0);
  EXPECT_EQ(measured.n_nothing_ahead, 0);
  EXPECT_LE(measured.largest_gap.value_mm, 2.0 * analysis::contact_margin_mm);
  EXPECT_GT(analysis::figures_of(analysis::audit(model, set, 1, 2)).n_overlapping, 0);
}

TEST(Jobs, EachIsJudgedByATest)
{
  const fs::path folder = test::source_directory() / "jobs";
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    found.push_back(entry.path().lexically_relative(folder).replace_extension());
  }
  std::vector<std::string> judged = test::shipped_jobs();
  // The campaign is solved below; a bench and lights are files of the player, which has their tests.
  judged.insert(judged.end(),
                {"campaign-example", "bench-desk", "bench-webcam", "lights-studio", "plus/bench"});
  EXPECT_THAT(found, testing::UnorderedElementsAreArray(judged));
}

class JobCheck : public testing::TestWithParam<std::string> {};

TEST_P(JobCheck, HasTheKnownWarnings)
{
  const std::string file = (test::source_directory() / "jobs" / (GetParam() + ".toml")).string();
  std::vector<std::string> words{"check", file};
  if (test::text_of(file).find("file = \"") != std::string::npos) {
    VRDA_REQUIRE_REAL_KNEES();
    words.insert(words.end(), {"--data", test::data_directory()->string()});
  }
  const test::Ended ended = test::run_vrda(words);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  test::expect_known_warnings(GetParam(), "check", ended);
}

std::string name_of_job(const testing::TestParamInfo<std::string>& job)
{
  std::string name = job.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == '/'; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Jobs, JobCheck, testing::ValuesIn(test::shipped_jobs()), name_of_job);

TEST(Jobs, EveryCaseOfTheCampaignHasTheKnownWarnings)
{
  const test::Scratch scratch;
  const fs::path folder = test::source_directory() / "jobs", output = scratch.path() / "out";
  scratch.write("knee-generic.toml", test::text_of(folder / "knee-generic.toml"));
  const fs::path campaign = scratch.write("campaign.toml", test::text_of(folder / "campaign-example.toml"));
  test::edit(campaign, "step = 5 }", "step = 15 }");  // the fine grid
  const test::Ended ended =
      test::run_vrda({"submit", campaign.string(), "-o", output.string(), "--local", "--workers", "1"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  int n_cases = 0;
  for (const auto& entry : fs::directory_iterator(output / "logs")) {
    const std::string name = entry.path().filename();
    if (name == "index.log") continue;
    SCOPED_TRACE(name);
    ++n_cases;
    const bool is_search = name.find("_search_") != std::string::npos;
    test::Ended run;
    run.err = test::text_of(entry.path());
    EXPECT_THAT(run.err, testing::HasSubstr(" stable"));
    test::expect_known_warnings(is_search ? "campaign-example search" : "campaign-example", "run", run);
  }
  EXPECT_EQ(n_cases, 12);
}

TEST(Jobs, TheHeadOfTheHipStaysInItsSocketOnBothSides)
{
  const test::Scratch scratch;
  const std::vector<std::string> coarse{"--set", "coordinates.flexion.step=30"};
  std::vector<std::string> coarse_left = coarse;
  coarse_left.insert(coarse_left.end(), {"--set", "side=left"});
  const store::MotionModel right = solved(scratch, "hip-generic.toml", coarse);
  const store::MotionModel left = solved(scratch, "hip-generic.toml", coarse_left);
  EXPECT_EQ(right.joint, "hip");
  EXPECT_FALSE(right.has_compartments);
  EXPECT_EQ(run::unsolved_fraction(right), 0.0) << run::status_line(right);
  expect_clean_poses(right);
  EXPECT_TRUE((right.plausibility == static_cast<std::int8_t>(Plausibility::nothing_found)).all());
  // The centre of the head moves by the clearance of both spheres, 0.5 mm. Facets of 2.2 mm on radii of 24 mm
  // are up to 2.2^2 / (8 * 24) = 0.025 mm inside their sphere, on both objects.
  const Eigen::ArrayXXd off_mm =
      (right.tx_mm.square() + right.ty_mm.square() + right.tz_mm.square()).sqrt() - 0.5;
  EXPECT_LT(off_mm.abs().maxCoeff(), 0.05);
  EXPECT_LT((left.clinical.anterior_mm - right.clinical.anterior_mm).abs().maxCoeff(), 1e-9);
  EXPECT_LT((left.clinical.lateral_mm - right.clinical.lateral_mm).abs().maxCoeff(), 1e-9);
}

TEST(Jobs, TheTalusTurnsAboutTheAxisOfItsTrochlea)
{
  const test::Scratch scratch;
  const store::MotionModel model = solved(scratch, "ankle-generic.toml", {});
  EXPECT_EQ(run::unsolved_fraction(model), 0.0) << run::status_line(model);
  expect_clean_poses(model);
  EXPECT_TRUE((model.plausibility == static_cast<std::int8_t>(Plausibility::nothing_found)).all());
  EXPECT_NEAR(model.clinical.flexion_deg.maxCoeff(), 40.0, 1e-9);  // rounding
  // The axis stays within the clearance of 0.5 mm; across it, facets of 2 mm on a radius of 20 mm differ from
  // the groove by up to 2^2 / (8 * 20) = 0.025 mm, which shifts an equilibrium by sqrt(2 * 0.025 * 0.5) mm.
  EXPECT_LT(model.ty_mm.maxCoeff(), 0.5 + 0.05);
  EXPECT_GT(model.ty_mm.minCoeff(), 0.5 - 0.05);
  EXPECT_LT(model.tx_mm.abs().maxCoeff(), 0.16);
}

TEST(Jobs, TheSubtalarJointStaysTogether)
{
  VRDA_REQUIRE_REAL_KNEES();
  const test::Scratch scratch;
  const store::MotionModel model =
      solved(scratch, "subtalar-01.toml",
             {"--data", test::data_directory()->string(), "--set", "coordinates.varus.step=10"});
  EXPECT_EQ(run::unsolved_fraction(model), 0.0) << run::status_line(model);
  expect_clean_poses(model);
  EXPECT_TRUE((model.plausibility == static_cast<std::int8_t>(Plausibility::nothing_found)).all());
  EXPECT_NEAR(model.clinical.varus_deg.minCoeff(), -10.0, 1e-9);  // rounding
}

class GenericKneeJob : public testing::TestWithParam<std::string> {};

TEST_P(GenericKneeJob, OnTheLeftHasTheClinicalNumbersOfTheRight)
{
  const test::Scratch scratch;
  std::vector<std::string> left_words = coarse_grid;
  left_words.insert(left_words.end(), {"--set", "side=left"});
  const store::MotionModel right = solved(scratch, GetParam() + ".toml", coarse_grid);
  const store::MotionModel left = solved(scratch, GetParam() + ".toml", left_words);
  ASSERT_EQ(left.side, "left");
  expect_clean_poses(left);
  expect_recontacted(left);
  // Equal travel on both sides; 1e-9 mm for another order of summation.
  const store::GridD difference = *left.smoothed.front().recontact_mm - *right.smoothed.front().recontact_mm;
  EXPECT_LE(difference.abs().maxCoeff(), 1e-9);
  EXPECT_TRUE((right.clinical.internal_rotation_deg == left.clinical.internal_rotation_deg).all());
  EXPECT_TRUE((right.clinical.varus_deg == left.clinical.varus_deg).all());
  EXPECT_TRUE((right.clinical.anterior_mm == left.clinical.anterior_mm).all());
  EXPECT_TRUE((right.clinical.proximal_mm == left.clinical.proximal_mm).all());
  EXPECT_TRUE((right.clinical.lateral_mm == left.clinical.lateral_mm).all());
  EXPECT_TRUE((right.tz_mm == -left.tz_mm).all());
}

INSTANTIATE_TEST_SUITE_P(Jobs, GenericKneeJob, testing::Values("knee-generic", "knee-generic-contact"),
                         name_of_job);

class RealKnee : public testing::TestWithParam<std::string> {};

TEST_P(RealKnee, EndsHonestlyWithoutPenetration)
{
  VRDA_REQUIRE_REAL_KNEES();
  const test::Scratch scratch;
  std::vector<std::string> words = coarse_grid;
  words.insert(words.end(), {"--data", test::data_directory()->string()});
  const store::MotionModel model = solved(scratch, "knee-" + GetParam() + ".toml", words);
  EXPECT_EQ(model.status.size(), 9);
  expect_clean_poses(model);
}

INSTANTIATE_TEST_SUITE_P(Jobs, RealKnee,
                         testing::Values("jam-smith2019", "jam-smith2019-ligaments", "pymskt-dess",
                                         "vhf-left", "vhf-right"),
                         name_of_job);

}  // namespace vrda::jobs_test
