// The jobs of the repository on coarse grids: each must give correct statuses, poses without overlap and no
// warning but the known ones; those of jobs/validation end as described in the thesis, chapter 4.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "analysis/audit.hpp"
#include "app/scenes.hpp"
#include "core/units.hpp"
#include "model/step_record.hpp"
#include "run/run_output.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "support/messages.hpp"
#include "support/real_knees.hpp"

namespace vrda::jobs_test {

namespace fs = std::filesystem;
using testing::IsEmpty;

// The warnings of the jobs in jobs/: each has a row with its reason, any other one fails a test.
struct Warning {
  const char* job;
  const char* command;  ///< of both commands if it is empty
  std::string about;
  test::Values values;
  const char* reason;
};

constexpr const char* open_sheet = "cartilage is segmented as a sheet without its side at the bone";
constexpr const char* as_segmented = "the mesh is the published segmentation, unchanged";
constexpr const char* both_methods = "the campaign compares both methods on one job with ligaments";

constexpr const char* no_ligaments = "without ligaments a real tibia turns and slides off";

const Warning warnings[] = {
    {"knee-vhf-left", "run", "/plausibility", {"6 dislocated", "9"}, no_ligaments},
    {"knee-vhf-right", "run", "/plausibility", {"3 dislocated", "9"}, no_ligaments},
    {"knee-pymskt-dess", "run", "/plausibility", {"1 border_contact", "9"}, as_segmented},
    {"knee-jam-smith2019", "run", "/plausibility", {"1 border_contact", "9"}, open_sheet},
    {"knee-jam-smith2019", "", "", {"\"meniscus_lateral\"", "intersect", "2"}, as_segmented},
    {"knee-jam-smith2019", "", "", {"\"meniscus_lateral\"", "folds", "3"}, as_segmented},
    {"knee-jam-smith2019-ligaments", "", "", {"\"meniscus_lateral\"", "folds", "3"}, as_segmented},
    {"subtalar-01", "", "", {"\"calcaneus\"", "needles", "2"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"femur_solid\"", "folds", "3"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"femur_solid\"", "needles", "5"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"meniscus_medial\"", "needles", "1"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"tibia_bone\"", "holes"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"tibia_bone\"", "winding", "1"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"meniscus_medial\"", "holes"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"meniscus_medial\"", "winding", "3"}, as_segmented},
    {"campaign-example search", "run", "ligaments", "stability search", both_methods},
    {"campaign-example search", "run", "push.force_n", "stability search", both_methods},
};

std::vector<std::string> shipped_jobs()
{
  return {"ankle-generic",
          "hip-generic",
          "knee-generic",
          "knee-generic-contact",
          "knee-jam-smith2019",
          "knee-jam-smith2019-ligaments",
          "knee-pymskt-dess",
          "knee-vhf-left",
          "knee-vhf-right",
          "subtalar-01",
          "validation/ball-in-dish",
          "validation/ball-on-non-monotone-slope",
          "validation/bar-on-pyramids",
          "validation/cap-in-sink",
          "validation/peg-in-hole"};
}

void expect_known_warnings(const std::string& job, const std::string& command, const test::Ended& ended)
{
  std::vector<testing::Matcher<std::string>> known;
  for (const Warning& row : warnings) {
    const std::string of_command = row.command;
    if (row.job == job && (of_command.empty() || of_command == command))
      known.emplace_back(test::warns(row.about, row.values));
  }
  std::vector<std::string> printed;
  std::istringstream lines(ended.out + ended.err);
  for (std::string line; std::getline(lines, line);)
    // The range of varus of these runs is narrower than their band of contact.
    if (line.starts_with("warning: ") && line.find("/zero_varus/is_cut_off") == std::string::npos)
      printed.push_back(line);
  EXPECT_THAT(printed, testing::UnorderedElementsAreArray(known)) << job << ", vrda " << command;
}

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
  expect_known_warnings(fs::path(job).stem(), "run", ended);
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
  std::vector<std::string> judged = shipped_jobs();
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
  expect_known_warnings(GetParam(), "check", ended);
}

std::string name_of_job(const testing::TestParamInfo<std::string>& job)
{
  std::string name = job.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == '/'; }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Jobs, JobCheck, testing::ValuesIn(shipped_jobs()), name_of_job);

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
    expect_known_warnings(is_search ? "campaign-example search" : "campaign-example", "run", run);
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
  EXPECT_LT(
      (left.clinical[JointCoordinate::anterior] - right.clinical[JointCoordinate::anterior]).abs().maxCoeff(),
      1e-9);
  EXPECT_LT(
      (left.clinical[JointCoordinate::lateral] - right.clinical[JointCoordinate::lateral]).abs().maxCoeff(),
      1e-9);
}

TEST(Jobs, TheTalusTurnsAboutTheAxisOfItsTrochlea)
{
  const test::Scratch scratch;
  const store::MotionModel model = solved(scratch, "ankle-generic.toml", {});
  EXPECT_EQ(run::unsolved_fraction(model), 0.0) << run::status_line(model);
  expect_clean_poses(model);
  EXPECT_TRUE((model.plausibility == static_cast<std::int8_t>(Plausibility::nothing_found)).all());
  EXPECT_NEAR(model.clinical[JointCoordinate::flexion].maxCoeff(), 40.0, 1e-9);  // rounding
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
  EXPECT_NEAR(model.clinical[JointCoordinate::varus].minCoeff(), -10.0, 1e-9);  // rounding
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
  for (std::size_t k = 1; k < n_joint_coordinates; ++k)
    EXPECT_TRUE((right.clinical[k] == left.clinical[k]).all()) << joint_coordinate_names[k];
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

constexpr double resolution_mm = 0.1, resolution_deg = 0.1;  // of every job

/// A job of one attitude, run from the command line.
struct Scene {
  explicit Scene(const std::string& job)
  {
    const test::Scratch scratch;
    const std::string output = (scratch.path() / "scene.h5").string();
    const std::string file = (test::source_directory() / "jobs" / "validation" / job).string();
    ended = test::run_vrda({"run", file, "-o", output, "--trace", "--progress", "none"});
    expect_known_warnings("validation/" + std::filesystem::path(job).stem().string(), "run", ended);
    model = store::read_motion_model(output);
    trace = store::read_trace(store::trace_name(output));
    store::require_trace_matches_model(trace, store::trace_name(output), model, output);
  }
  StepStatus status() const { return static_cast<StepStatus>(model.status(0, 0)); }
  int count(MoveKind kind) const
  {
    return static_cast<int>(
        std::count(trace.moves.kind.begin(), trace.moves.kind.end(), static_cast<std::int8_t>(kind)));
  }
  /// Position of the moving object after a move.
  Eigen::Vector3d at(std::size_t move) const
  {
    return trace.moves.translation_mm.row(static_cast<Eigen::Index>(move)).cast<double>();
  }
  std::size_t last_move() const { return trace.moves.kind.size() - 1; }

  test::Ended ended;
  store::MotionModel model;
  store::Trace trace;
};

void expect_run(const Scene& scene, StepStatus status)
{
  EXPECT_EQ(scene.ended.exit_code, 0) << scene.ended.err;
  ASSERT_EQ(scene.model.status.size(), 1);
  EXPECT_EQ(scene.status(), status);
  ASSERT_EQ(scene.trace.searches.node.size(), 1U);
}

// A stable search ends in contact, at the pose of the motion model within the precision of the trace.
void expect_last_touch_at_rest(const Scene& scene)
{
  ASSERT_FALSE(scene.trace.moves.in_contact.empty());
  EXPECT_EQ(scene.trace.moves.in_contact.back(), 1);
  EXPECT_EQ(store::moves_in_contact(scene.trace, 0).back(), scene.last_move());
  const Eigen::Vector3d rest(scene.model.tx_mm(0, 0), scene.model.ty_mm(0, 0), scene.model.tz_mm(0, 0));
  EXPECT_LT((scene.at(scene.last_move()) - rest).norm(), 1e-5);
  EXPECT_GT(scene.trace.moves.contact_start.back(), *(scene.trace.moves.contact_start.end() - 2));
}

// Generated on the axis and displaced by moving.initial: its translation is the error.
void expect_ball_in_the_middle(const std::string& job)
{
  const Scene scene(job);
  expect_run(scene, StepStatus::stable);
  expect_last_touch_at_rest(scene);
  const Eigen::Vector3d first = scene.at(store::moves_in_contact(scene.trace, 0).front());
  EXPECT_GT(std::hypot(first.x(), first.z()), 13.0);
  EXPECT_LT(std::hypot(scene.model.tx_mm(0, 0), scene.model.tz_mm(0, 0)), 2.0 * resolution_mm)
      << "halving from 1 mm can miss by 1.25 resolutions";
  EXPECT_GT(scene.count(MoveKind::translate), 10);
}

TEST(ValidationJobs, TheBallEndsInTheMiddleOfTheDish)
{
  expect_ball_in_the_middle("ball-in-dish.toml");
}

TEST(ValidationJobs, TheBallEndsInTheMiddleOfANonMonotoneSlope)
{
  expect_ball_in_the_middle("ball-on-non-monotone-slope.toml");
}

TEST(ValidationJobs, TheBallGoesThroughTheHole)
{
  const Scene scene("peg-in-hole.toml");
  expect_run(scene, StepStatus::no_contact);
  EXPECT_EQ(scene.trace.searches.status[0], static_cast<std::int8_t>(StepStatus::no_contact));
  // It ends when the ball of 5 mm clears the hole of 12 mm on all sides; the polyhedron is at most 0.1 mm
  // inside the ball. The last contact is one step of at most 1 mm along each axis before that.
  const double room_mm = 6.0 - 5.0 + 0.1;
  const Eigen::Vector3d first = scene.at(store::moves_in_contact(scene.trace, 0).front());
  const Eigen::Vector3d touch = scene.at(store::moves_in_contact(scene.trace, 0).back());
  const Eigen::Vector3d end = scene.at(scene.last_move());
  EXPECT_GT(std::hypot(first.x(), first.z()), 12.0);
  EXPECT_LT(std::max(std::abs(touch.x()), std::abs(touch.z())), room_mm + 1.0);
  EXPECT_LT(std::max(std::abs(end.x()), std::abs(end.z())), room_mm);
  EXPECT_EQ(scene.trace.moves.kind.back(), static_cast<std::int8_t>(MoveKind::translate));
}

TEST(ValidationJobs, ANarrowerHoleHoldsTheBall)
{
  // As described in the job's comment.
  const test::Scratch scratch;
  std::string text = test::text_of(test::source_directory() / "jobs" / "validation" / "peg-in-hole.toml");
  const std::string wide = "hole = 12";
  for (std::size_t at = text.find(wide, text.find("[reference]")); at != std::string::npos;
       at = text.find(wide, at))
    text.replace(at, wide.size(), "hole = 8");
  const std::string job = scratch.write("narrow.toml", text).string();
  const std::string output = (scratch.path() / "narrow.h5").string();
  EXPECT_EQ(test::run_vrda({"run", job, "-o", output, "--progress", "none"}).exit_code, 0);
  EXPECT_EQ(static_cast<StepStatus>(store::read_motion_model(output).status(0, 0)), StepStatus::stable);
}

TEST(ValidationJobs, TheBarTurnsUntilItFitsBetweenThePyramids)
{
  const Scene scene("bar-on-pyramids.toml");
  expect_run(scene, StepStatus::stable);
  expect_last_touch_at_rest(scene);
  // On the floor: generated 20 mm below it.
  EXPECT_NEAR(scene.model.ty_mm(0, 0), 20.0, resolution_mm);
  // Between bases 20 mm long and 10 mm apart a bar of 8 mm fits when 8 / cos + 20 tan is at most 10.
  const double theta_rad = std::abs(rad_from_deg(scene.model.theta_deg(0, 0)));
  EXPECT_LE(8.0 / std::cos(theta_rad) + 20.0 * std::tan(theta_rad), 10.0 + resolution_mm);
  EXPECT_GT(scene.count(MoveKind::rotate), 10) << "from 30 degrees";
}

TEST(ValidationJobs, TheCapSitsInTheSink)
{
  const Scene scene("cap-in-sink.toml");
  expect_run(scene, StepStatus::stable);
  expect_last_touch_at_rest(scene);
  // Tip in tip: generated 25 mm below it, with faces of equal slope.
  EXPECT_NEAR(scene.model.ty_mm(0, 0), 25.0, resolution_mm);
  EXPECT_LT(std::hypot(scene.model.tx_mm(0, 0), scene.model.tz_mm(0, 0)), resolution_mm);
  // Rotation tolerance: the rotation resolution, or the angle that moves its sides (at 14 mm) by the
  // translation resolution.
  EXPECT_LE(std::abs(scene.model.theta_deg(0, 0)), resolution_deg + deg_from_rad(resolution_mm / 14.0));
  EXPECT_GT(scene.count(MoveKind::rotate), 10) << "from 30 degrees";
  EXPECT_GT(scene.count(MoveKind::translate), 0) << "from a position off the centre";
}

}  // namespace vrda::jobs_test
